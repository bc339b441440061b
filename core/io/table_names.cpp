// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/table_names.hpp"

#include <algorithm>

#include "base/text.hpp"
#include "io/text_lines.hpp"

namespace surfaced::io {
namespace {

constexpr std::array<std::string_view, kRoles + 1> kRoleNames{"x", "y", "z", "nx", "ny", "nz", "r", "g", "b", "-"};

/// Words that programs put before or behind the letter of an axis.
constexpr auto kAxisWords = std::to_array<std::string_view>(
    {"",      "pos",    "position", "positions", "coord",  "coords", "coordinate", "coordinates", "koordinate",
     "koord", "point",  "points",   "pt",        "p",      "loc",    "location",   "cartesian",   "utm",
     "world", "local",  "m",        "mm",        "cm",     "ft",     "km",         "meter",       "meters",
     "metre", "metres", "center",   "centre",    "vertex", "global", "xyz"});
constexpr auto kNormalWords = std::to_array<std::string_view>({"n", "normal", "normals", "norm"});
constexpr auto kColorWords =
    std::to_array<std::string_view>({"", "color", "colour", "col", "rgb", "f", "diffuse", "color8", "scan"});

/// What has an x, y and z too, and is no place.
constexpr auto kOtherVectors = std::to_array<std::string_view>(
    {"n",     "normal",       "normals",  "norm",      "v",     "vel",     "velocity",    "a",       "acc",
     "accel", "acceleration", "f",        "force",     "s",     "std",     "sigma",       "sd",      "err",
     "error", "rot",          "rotation", "angle",     "euler", "q",       "quat",        "gyro",    "mag",
     "scale", "size",         "dir",      "direction", "t",     "tangent", "orientation", "angular", "linear"});

/// What surveyors call the axes.
constexpr auto kEast =
    std::to_array<std::string_view>({"easting", "eastings", "east", "rechtswert", "rechts", "ostwert", "ost", "este",
                                     "est", "xeast", "xeasting", "eastx", "eastingx", "me"});
constexpr auto kNorth =
    std::to_array<std::string_view>({"northing", "northings", "north", "hochwert", "hoch", "nordwert", "nord", "norte",
                                     "ynorth", "ynorthing", "northy", "northingy", "mn"});
constexpr auto kUp = std::to_array<std::string_view>({"height", "elevation", "elev", "ele", "altitude", "alt", "hoehe",
                                                      "h\xc3\xb6he", "h\xf6he", "level", "rl", "cota", "quota",
                                                      "zheight", "heightz", "zelev", "zelevation", "h", "up"});
/// What such a name may begin with.
constexpr auto kWhose =
    std::to_array<std::string_view>({"ortho", "orthometric", "ellipsoidal", "ellipsoid", "ell", "grid", "local",
                                     "ground", "geoid", "project", "point", "utm"});
constexpr auto kLongitude = std::to_array<std::string_view>({"lon", "long", "lng", "longitude", "londeg"});
constexpr auto kLatitude = std::to_array<std::string_view>({"lat", "latitude", "latdeg"});

bool is_among(const auto& words, std::string_view word) { return std::ranges::find(words, word) != words.end(); }

/// The name without what is no letter or digit; ASCII letters small.
std::string plain(std::string_view name) {
  std::string letters;
  for (const char c : in_lower_case(name)) {
    const bool kept = (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || static_cast<unsigned char>(c) >= 0x80;
    if (kept) letters += c;
  }
  return letters;
}

/// Whether the name is the letter of an axis, or its number, beside one of the words; the number not alone.
bool is_axis(std::string_view name, const auto& words, std::string_view letter, std::string_view number) {
  if (name.starts_with(letter) && is_among(words, name.substr(letter.size()))) return true;
  if (name.ends_with(letter) && is_among(words, name.substr(0, name.size() - letter.size()))) return true;
  if (name.size() < 2 || !name.ends_with(number)) return false;
  const std::string_view stem = name.substr(0, name.size() - 1);
  return is_among(words, stem) || (stem.ends_with("xyz") && is_among(words, "xyz"));
}

/// Whether what stands before the letter of an axis says that the three are no place: vel, or pose.orientation.
bool is_other_vector(std::string_view before) {
  constexpr std::size_t kShortest = 4;
  return is_among(kOtherVectors, before) || std::ranges::any_of(kOtherVectors, [&](std::string_view word) {
           return word.size() >= kShortest && before.ends_with(word);
         });
}

/// A surveyor's word, also with a unit behind it or a word for coordinates on either side.
bool is_word(const auto& words, std::string_view name) {
  for (const std::string_view more : {"", "m", "ft", "meters", "metres", "coord", "coordinate", "koordinate"}) {
    if (name.ends_with(more) && is_among(words, name.substr(0, name.size() - more.size()))) return true;
  }
  return std::ranges::any_of(kWhose, [&](std::string_view whose) {
    return name.starts_with(whose) && is_among(words, name.substr(whose.size()));
  });
}

using Names = std::vector<std::string>;

template <class Is>
std::optional<std::size_t> find_name(const Names& names, Is is) {
  const auto found = std::ranges::find_if(names, is);
  if (found == names.end()) return std::nullopt;
  return static_cast<std::size_t>(found - names.begin());
}

/// The three columns of a group, if all are there.
void take_group(const Names& names, const auto& words, const std::array<std::string_view, 3>& letters, Role first,
                HeaderMeaning& meaning) {
  std::array<std::size_t, 3> columns{};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto number = std::array<std::string_view, 3>{"0", "1", "2"}.at(i);
    const auto found =
        find_name(names, [&](const std::string& name) { return is_axis(name, words, letters.at(i), number); });
    if (!found || meaning.roles[*found] != Role::none) return;
    columns.at(i) = *found;
  }
  for (std::size_t i = 0; i < 3; ++i) {
    meaning.roles[columns.at(i)] = static_cast<Role>(static_cast<std::size_t>(first) + i);
  }
}

/// East or north, or the letter, alone or behind a word for coordinates, where the other letter stands so too.
std::optional<std::size_t> find_compass(const Names& names, const auto& words, char letter, const char* other) {
  const auto found = find_name(names, [&](const std::string& name) { return is_word(words, name); });
  if (found) return found;
  return find_name(names, [&](const std::string& name) {
    const std::string before = name.substr(0, name.empty() ? 0 : name.size() - 1);
    return name.ends_with(letter) && is_among(kAxisWords, before) && is_among(names, before + other);
  });
}

/// Three names that differ in the letter of an axis alone, as field.x, field.y, field.z, or X1, X2, X3 with nothing
/// beside them. None if there are several such.
std::optional<std::array<std::size_t, 3>> find_alike(const Names& names) {
  std::optional<std::array<std::size_t, 3>> alike;
  for (std::size_t c = 0; c < names.size(); ++c) {
    for (std::size_t i = 0; i < names[c].size(); ++i) {
      const bool numbered = names.size() == 3 && i > 0 && names[c][i] == '1';
      if ((names[c][i] != 'x' && !numbered) || is_other_vector(std::string_view(names[c]).substr(0, i))) continue;
      const auto with = [&](char letter) {
        std::string name = names[c];
        name[i] = letter;
        return find_name(names, [&](const std::string& each) { return each == name; });
      };
      const auto second = with(numbered ? '2' : 'y');
      const auto third = with(numbered ? '3' : 'z');
      if (!second || !third) continue;
      if (alike) return std::nullopt;
      alike = {c, *second, *third};
    }
  }
  return alike;
}

void take_position(const Names& names, HeaderMeaning& meaning) {
  const auto axis = [&](const char* letter, const char* number) {
    return find_name(names, [&](const std::string& name) { return is_axis(name, kAxisWords, letter, number); });
  };
  const auto up = [&] { return find_name(names, [](const std::string& name) { return is_word(kUp, name); }); };
  const std::array own{axis("x", "0"), axis("y", "1"), axis("z", "2")};
  const bool letters = own[0] && own[1];
  std::array taken{letters ? own[0] : find_compass(names, kEast, 'e', "n"),
                   letters ? own[1] : find_compass(names, kNorth, 'n', "e"), own[2] ? own[2] : up()};
  if (const auto alike = find_alike(names); alike && !(taken[0] && taken[1] && taken[2])) {
    taken = {alike->at(0), alike->at(1), alike->at(2)};
  }
  if (taken[0] && taken[1] && taken[2]) {
    for (std::size_t i = 0; i < 3; ++i) meaning.roles[*taken.at(i)] = static_cast<Role>(i);
    meaning.has_position = true;
    meaning.synonyms = !letters || !own[2];
    return;
  }
  // GPSLatitude, decimalLongitude and the like.
  const auto has = [&](const auto& words) {
    return std::ranges::any_of(names, [&](const std::string& name) {
      return is_among(words, name) || std::ranges::any_of(words, [&](std::string_view word) {
               return word.size() > 7 && name.find(word) != std::string::npos;
             });
    });
  };
  meaning.degrees = has(kLongitude) && has(kLatitude);
}

}  // namespace

std::string_view name_of(Role role) { return kRoleNames.at(static_cast<std::size_t>(role)); }

std::optional<std::vector<Role>> roles_named(std::string_view list) {
  std::vector<Role> roles;
  std::array<bool, kRoles + 1> seen{};
  for (bool more = true; more;) {
    const std::size_t end = list.find(',');
    const auto* found = std::ranges::find(kRoleNames, list.substr(0, end));
    if (found == kRoleNames.end()) return std::nullopt;
    const auto index = static_cast<std::size_t>(found - kRoleNames.begin());
    const auto role = static_cast<Role>(index);
    if (role != Role::none && seen.at(index)) return std::nullopt;
    seen.at(index) = true;
    roles.push_back(role);
    more = end != std::string_view::npos;
    if (more) list.remove_prefix(end + 1);
  }
  const auto whole = [&](std::size_t first) { return seen.at(first) && seen.at(first + 1) && seen.at(first + 2); };
  const auto none = [&](std::size_t first) { return !seen.at(first) && !seen.at(first + 1) && !seen.at(first + 2); };
  if (!whole(0) || !(whole(3) || none(3)) || !(whole(6) || none(6))) return std::nullopt;
  return roles;
}

HeaderMeaning meaning_of(const std::vector<std::string_view>& cells) {
  Names names;
  for (const std::string_view cell : cells) names.push_back(plain(cell));
  HeaderMeaning meaning{.roles = std::vector<Role>(cells.size(), Role::none)};
  take_position(names, meaning);
  take_group(names, kNormalWords, {"x", "y", "z"}, Role::nx, meaning);
  take_group(names, kColorWords, {"r", "g", "b"}, Role::r, meaning);
  if (std::ranges::find(meaning.roles, Role::r) == meaning.roles.end()) {
    take_group(names, kColorWords, {"red", "green", "blue"}, Role::r, meaning);
  }
  return meaning;
}

std::string without_units(std::string_view line) {
  constexpr std::size_t kLongest = 12;
  std::string text;
  while (!line.empty()) {
    const char open = line.front();
    const std::size_t end = open == '[' ? line.find(']') : open == '(' ? line.find(')') : std::string_view::npos;
    const bool index = end == 2 && line[1] >= '0' && line[1] <= '9';
    if (end == std::string_view::npos || end > kLongest || index) {
      text += open;
      line.remove_prefix(1);
      continue;
    }
    line.remove_prefix(end + 1);
  }
  return text;
}

}  // namespace surfaced::io
