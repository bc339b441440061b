// SPDX-License-Identifier: GPL-3.0-or-later
#include "worker/convert.hpp"

#include "reconstruction/reconstruction.hpp"

namespace surfaced {

Status convert_mesh(const std::filesystem::path& mesh, const std::filesystem::path& output,
                    const nlohmann::ordered_json& parameters, nlohmann::ordered_json report) {
  const auto format = mesh_format_of(output);
  if (!format) return format.error();
  const auto decoded = read_mesh(mesh);
  if (!decoded) return decoded.error();
  const auto bytes = encode_again(*decoded, *format, parameters, std::move(report));
  if (!bytes) return bytes.error();
  return write_file(output, *bytes);
}

}  // namespace surfaced
