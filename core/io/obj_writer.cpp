// SPDX-License-Identifier: GPL-3.0-or-later
// Wavefront OBJ: coordinates as the shortest decimals that read back as the same doubles; colours behind the position,
// as many programs read them.
#include "io/decimal.hpp"
#include "io/formats.hpp"

namespace surfaced::io {
namespace {

/// Three digits tell 256 shades apart; a fourth makes rounding safe.
constexpr int kShades = 10000;

template <class T>
void append_three(std::string& text, const char* keyword, const std::array<T, 3>& values) {
  text += keyword;
  for (const T x : values) {
    text += ' ';
    append_decimal(text, x);
  }
}

void append_color(std::string& text, const Color4& color) {
  for (std::size_t c = 0; c < 3; ++c) {
    text += ' ';
    append_decimal(text, (color[c] * kShades + 127) / 255 / static_cast<double>(kShades));
  }
}

}  // namespace

Result<Bytes> write_obj_mesh(const TriangleMesh& mesh) {
  std::string text = "# surfaced " SURFACED_VERSION "\n";
  text.reserve(mesh.positions.size() * 40 + mesh.triangles.size() * 24);
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    append_three(text, "v", mesh.positions[v]);
    if (!mesh.colors.empty()) append_color(text, mesh.colors[v]);
    text += '\n';
  }
  for (const Normal3& normal : mesh.normals) {
    append_three(text, "vn", normal);
    text += '\n';
  }
  for (const Triangle& t : mesh.triangles) {
    text += 'f';
    for (const VertexIndex v : t) {
      text += ' ';
      append_decimal(text, std::uint64_t{v.value} + 1);
      if (mesh.normals.empty()) continue;
      text += "//";
      append_decimal(text, std::uint64_t{v.value} + 1);
    }
    text += '\n';
  }
  return bytes_of_text(text);
}

}  // namespace surfaced::io
