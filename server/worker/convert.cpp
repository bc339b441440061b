#include "worker/convert.hpp"

#include "io/io.hpp"

namespace surfaced {

Status convert_mesh(const std::filesystem::path& mesh, const std::filesystem::path& output,
                    const nlohmann::ordered_json& parameters, nlohmann::ordered_json report) {
  const auto format = mesh_format_of(output);
  if (!format) return format.error();
  const auto decoded = read_mesh(mesh);
  if (!decoded) return decoded.error();
  EncodeOptions options;
  options.up = parameters.value("up", "y") == "z" ? UpAxis::z : UpAxis::y;
  const std::string unit = parameters.value("unit", "mm");
  if (unit == "cm") options.unit = Unit::centimetre;
  if (unit == "m") options.unit = Unit::metre;
  if (unit == "in") options.unit = Unit::inch;
  if (const auto bits = parameters.find("quantization"); bits != parameters.end() && bits->is_number()) {
    options.quantization_bits = bits->get<int>();
  }
  const bool takes_extras = *format == MeshFormat::glb || *format == MeshFormat::gltf;
  if (takes_extras && report.is_object()) {
    for (const char* const of_the_run : {"stages", "resources"}) report.erase(of_the_run);
    if (report.contains("provenance")) report["provenance"].erase("input_sha256");
    if (report.contains("encoding")) {
      report["encoding"].erase("bytes");
      report["encoding"]["format"] = output.extension().string().substr(1);
    }
    options.extras_json = report.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
  }
  const auto bytes = encode_mesh(*decoded, *format, options);
  if (!bytes) return bytes.error();
  return write_file(output, *bytes);
}

}  // namespace surfaced
