// SPDX-License-Identifier: GPL-3.0-or-later
#include <iomanip>
#include <iostream>
#include <memory>
#include <sstream>

#include "base/text.hpp"
#include "command/command.hpp"
#include "reconstruction/reconstruction.hpp"

namespace surfaced {
namespace {

/// A default or a choice as it is typed behind `name=`.
std::string typed(const Json& value) { return value.is_string() ? value.get<std::string>() : value.dump(); }

/// A limit, whole ones without a fraction.
std::string limit(const Json& schema, const char* name) {
  std::ostringstream text;
  text << std::setprecision(15) << schema.at(name).get<double>();
  return text.str();
}

/// What may be typed behind `name=`, in words.
std::string choices(const Json& schema) {
  if (schema.contains("const")) return typed(schema.at("const"));
  std::string text;
  for (const char* list : {"oneOf", "enum"}) {
    if (!schema.contains(list)) continue;
    return joined(schema.at(list), ", ",
                  [](const Json& each) { return each.is_object() ? choices(each) : typed(each); });
  }
  if (schema.at("type") == "boolean") return "true, false";
  if (schema.at("type") == "integer") text = "whole, ";
  if (schema.contains("minimum")) text += "from " + limit(schema, "minimum");
  if (schema.contains("exclusiveMinimum")) text += "above " + limit(schema, "exclusiveMinimum");
  if (schema.contains("maximum")) text += " to " + limit(schema, "maximum");
  return text;
}

/// Breaks the text at spaces and indents every line.
void print_wrapped(const std::string& text, const std::string& indent) {
  constexpr std::size_t kWidth = 110;
  std::istringstream words(text);
  std::string line = indent;
  for (std::string word; words >> word;) {
    if (line.size() + word.size() > kWidth && line.size() > indent.size()) {
      std::cout << line << "\n";
      line = indent;
    }
    line += (line.size() > indent.size() ? " " : "") + word;
  }
  std::cout << line << "\n";
}

void print_parameter(const std::string& name, const Json& schema) {
  std::cout << "  " << name << "=" << typed(schema.at("default")) << "  (" << choices(schema);
  if (const auto unit = schema.find("x-unit"); unit != schema.end() && *unit != "1") {
    std::cout << "; " << unit->get<std::string>();
  }
  std::cout << ")\n";
  print_wrapped(schema.at("description").get<std::string>(), "      ");
}

/// Parameters that every method has with the same schema.
Json shared_parameters() {
  Json shared = methods().front().parameters.at("properties");
  for (const MethodInfo& method : methods()) {
    const Json& own = method.parameters.at("properties");
    for (auto each = shared.begin(); each != shared.end();) {
      each = own.contains(each.key()) && own.at(each.key()) == each.value() ? std::next(each) : shared.erase(each);
    }
  }
  return shared;
}

void print_as_text() {
  const Json shared = shared_parameters();
  for (const MethodInfo& method : methods()) {
    std::cout << method.id << ": " << method.title << "\n";
    print_wrapped(method.summary, "  ");
    print_wrapped(method.source, "  ");
    for (const auto& [name, schema] : method.parameters.at("properties").items()) {
      if (!shared.contains(name)) print_parameter(name, schema);
    }
    std::cout << "\n";
  }
  std::cout << "Every method also takes:\n";
  for (const auto& [name, schema] : shared.items()) print_parameter(name, schema);
}

}  // namespace

void add_methods(CLI::App& app, Run& run) {
  auto as_json = std::make_shared<bool>(false);
  CLI::App* command = app.add_subcommand("methods", "List the methods and their parameters");
  command->add_flag("--json", *as_json, "As JSON, with the JSON Schemas of the parameters; errors too")
      ->envname("SURFACED_JSON");
  command->callback([as_json, &run] {
    run = [as_json] {
      if (*as_json) {
        std::cout << methods_json().dump(2) << "\n";
      } else {
        print_as_text();
      }
      return 0;
    };
  });
}

}  // namespace surfaced
