// SPDX-License-Identifier: GPL-3.0-or-later
// Files with random headers, read here and by a parser that is as simple as can be.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <map>
#include <random>
#include <sstream>

#include "io/io.hpp"
#include "support/ply_files.hpp"
#include "support/results.hpp"

namespace surfaced {
namespace {

using namespace surfaced::testing;

struct Property {
  std::string name;
  std::string type;
  std::string count_type;
};

struct Element {
  std::string name;
  std::uint64_t count = 0;
  std::vector<Property> properties;
};

/// Reads one value at a time, by the book.
class NaiveParser {
 public:
  explicit NaiveParser(const std::string& text) {
    std::istringstream lines(text);
    std::string line;
    std::size_t at = 0;
    while (std::getline(lines, line)) {
      at += line.size() + 1;
      if (!line.empty() && line.back() == '\r') line.pop_back();
      std::istringstream words(line);
      std::string word;
      words >> word;
      if (word == "format") words >> format_;
      if (word == "element") {
        elements_.emplace_back();
        words >> elements_.back().name >> elements_.back().count;
      }
      if (word == "property") {
        Property p;
        words >> p.type;
        if (p.type == "list") words >> p.count_type >> p.type;
        words >> p.name;
        elements_.back().properties.push_back(p);
      }
      if (word == "end_header") break;
    }
    body_ = text.substr(at);
    tokens_.str(body_);
  }

  /// Values of every vertex by name; lists are read over.
  std::vector<std::map<std::string, double>> vertices() {
    std::vector<std::map<std::string, double>> rows;
    for (const Element& element : elements_) {
      for (std::uint64_t i = 0; i < element.count; ++i) {
        std::map<std::string, double> row;
        for (const Property& p : element.properties) {
          if (p.count_type.empty()) {
            row[p.name] = next(p.type);
          } else {
            for (double n = next(p.count_type); n > 0; --n) next(p.type);
          }
        }
        if (element.name == "vertex") rows.push_back(row);
      }
    }
    return rows;
  }

 private:
  double next(const std::string& type) {
    if (format_ == "ascii") {
      std::string token;
      tokens_ >> token;
      return type == "float" || type == "float32" ? static_cast<double>(std::strtof(token.c_str(), nullptr))
                                                  : std::strtod(token.c_str(), nullptr);
    }
    if (type == "char" || type == "int8") return take<std::int8_t>();
    if (type == "uchar" || type == "uint8") return take<std::uint8_t>();
    if (type == "short" || type == "int16") return take<std::int16_t>();
    if (type == "ushort" || type == "uint16") return take<std::uint16_t>();
    if (type == "int" || type == "int32") return take<std::int32_t>();
    if (type == "uint" || type == "uint32") return take<std::uint32_t>();
    if (type == "float" || type == "float32") return static_cast<double>(take<float>());
    return take<double>();
  }

  template <class T>
  T take() {
    std::string bytes = body_.substr(at_, sizeof(T));
    at_ += sizeof(T);
    if (format_ == "binary_big_endian") std::ranges::reverse(bytes);
    T value{};
    std::memcpy(&value, bytes.data(), sizeof(T));
    return value;
  }

  std::string format_;
  std::vector<Element> elements_;
  std::string body_;
  std::size_t at_ = 0;
  std::istringstream tokens_;
};

class RandomPly {
 public:
  explicit RandomPly(std::uint32_t seed) : random_(seed) {}

  std::string make() {
    std::vector<Element> elements;
    for (std::size_t i = pick(3); i > 0; --i) elements.push_back(other_element(elements.size()));
    elements.push_back(vertex_element());
    for (std::size_t i = pick(3); i > 0; --i) elements.push_back(other_element(elements.size()));
    PlyBuilder ply(std::array{PlyForm::ascii, PlyForm::little, PlyForm::big}.at(pick(3)));
    for (const Element& element : elements) declare(ply, element);
    for (const Element& element : elements) {
      for (std::uint64_t row = 0; row < element.count; ++row) fill(ply, element);
    }
    return ply.text();
  }

 private:
  std::size_t pick(std::size_t below) { return random_() % below; }

  std::string any_type() {
    constexpr std::array kTypes{"char", "int8",  "uchar", "uint8",  "short", "int16",   "ushort", "uint16",
                                "int",  "int32", "uint",  "uint32", "float", "float32", "double", "float64"};
    return kTypes.at(pick(kTypes.size()));
  }

  Property extra(std::size_t number) {
    Property p{"extra" + std::to_string(number), any_type(), ""};
    if (pick(3) == 0) p.count_type = std::array{"uchar", "uint8", "short", "ushort", "int", "uint32"}.at(pick(6));
    return p;
  }

  Element other_element(std::size_t number) {
    Element element{"other" + std::to_string(number), pick(6), {}};
    for (std::size_t i = pick(4); i > 0; --i) element.properties.push_back(extra(element.properties.size()));
    return element;
  }

  Element vertex_element() {
    Element element{"vertex", 1 + pick(30), {}};
    for (const char* axis : {"x", "y", "z"}) element.properties.push_back({axis, any_type(), ""});
    if (pick(2) == 0) {
      for (const char* axis : {"nx", "ny", "nz"}) element.properties.push_back({axis, "float", ""});
    }
    if (pick(2) == 0) {
      for (const char* channel : {"red", "green", "blue"}) element.properties.push_back({channel, "uchar", ""});
    }
    for (std::size_t i = pick(4); i > 0; --i) element.properties.push_back(extra(element.properties.size()));
    std::ranges::shuffle(element.properties, random_);
    return element;
  }

  void declare(PlyBuilder& ply, const Element& element) {
    if (pick(3) == 0) ply.line("comment element vertex 1000000");
    ply.element(element.name, element.count);
    for (const Property& p : element.properties) {
      p.count_type.empty() ? ply.property(p.type, p.name) : ply.list(p.count_type, p.type, p.name);
    }
  }

  void fill(PlyBuilder& ply, const Element& element) {
    for (const Property& p : element.properties) {
      if (p.count_type.empty()) {
        ply.value(p.type, any_value(p.type));
        continue;
      }
      std::vector<double> values(pick(5));
      for (double& v : values) v = any_value(p.type);
      ply.list_value(p.count_type, p.type, values);
    }
    if (!element.properties.empty()) ply.end_row();
  }

  double any_value(const std::string& type) {
    if (type.starts_with("float") || type == "double") {
      const double mantissa = std::uniform_real_distribution<double>(-1, 1)(random_);
      return std::ldexp(mantissa, static_cast<int>(pick(60)) - 30);
    }
    const bool is_unsigned = type.starts_with('u');
    const int bits = type.ends_with('8') || type.ends_with("char")     ? 8
                     : type.ends_with("16") || type.ends_with("short") ? 16
                                                                       : 32;
    const double span = std::ldexp(1, bits);
    const double value = std::floor(std::uniform_real_distribution<double>(0, span)(random_));
    return is_unsigned ? value : value - span / 2;
  }

  std::mt19937 random_;
};

TEST(PlyProperty, reads_random_files_as_the_naive_parser_does) {
  for (std::uint32_t seed = 0; seed < 3000; ++seed) {
    const std::string text = RandomPly(seed).make();
    const auto cloud = parse_text(text);
    ASSERT_TRUE(cloud.ok()) << "seed " << seed << ": " << detail_of(cloud);
    const auto rows = NaiveParser(text).vertices();
    ASSERT_EQ(cloud->size(), rows.size()) << "seed " << seed;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const auto& row = rows[i];
      EXPECT_EQ(cloud->positions[i], (Point3{row.at("x"), row.at("y"), row.at("z")})) << "seed " << seed;
      if (row.contains("nx")) {
        EXPECT_EQ(cloud->normals[i], (Normal3{static_cast<float>(row.at("nx")), static_cast<float>(row.at("ny")),
                                              static_cast<float>(row.at("nz"))}))
            << "seed " << seed;
      }
      if (row.contains("red")) {
        EXPECT_EQ(cloud->colors[i],
                  (Color4{static_cast<std::uint8_t>(row.at("red")), static_cast<std::uint8_t>(row.at("green")),
                          static_cast<std::uint8_t>(row.at("blue")), 255}))
            << "seed " << seed;
      }
    }
  }
}

TEST(PlyProperty, a_changed_byte_never_gives_a_cloud_of_uneven_arrays) {
  std::mt19937 random(7);
  for (std::uint32_t seed = 0; seed < 300; ++seed) {
    std::string text = RandomPly(seed).make();
    for (int flip = 0; flip < 30; ++flip) {
      std::string damaged = text;
      damaged[random() % damaged.size()] ^= static_cast<char>(1 << random() % 8);
      const auto cloud = parse_text(damaged);
      if (!cloud) {
        EXPECT_FALSE(detail_of(cloud).empty());
        continue;
      }
      EXPECT_TRUE(cloud->normals.empty() || cloud->normals.size() == cloud->size());
      EXPECT_TRUE(cloud->colors.empty() || cloud->colors.size() == cloud->size());
    }
  }
}

}  // namespace
}  // namespace surfaced
