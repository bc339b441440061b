#include <iostream>
#include <memory>

#include "command/command.hpp"
#include "reconstruction/reconstruction.hpp"

namespace surfaced {
namespace {

void print_as_text(const MethodInfo& method) {
  std::cout << method.id << ": " << method.title << "\n  " << method.summary << "\n";
  for (const auto& [name, schema] : method.parameters.at("properties").items()) {
    std::cout << "    " << name << " = " << schema.at("default").dump() << "  "
              << schema.at("description").get<std::string>() << "\n";
  }
  std::cout << "  " << method.source << "\n\n";
}

}  // namespace

void add_methods(CLI::App& app, Run& run) {
  auto as_json = std::make_shared<bool>(false);
  CLI::App* command = app.add_subcommand("methods", "List the methods and their parameters");
  command->add_flag("--json", *as_json, "As JSON, with the JSON Schemas of the parameters")->envname("SURFACED_JSON");
  command->callback([as_json, &run] {
    run = [as_json] {
      if (*as_json) {
        std::cout << methods_json().dump(2) << "\n";
      } else {
        for (const MethodInfo& method : methods()) print_as_text(method);
      }
      return 0;
    };
  });
}

}  // namespace surfaced
