// SPDX-License-Identifier: GPL-3.0-or-later
#include "io/gltf_transform.hpp"

#include <cmath>
#include <vector>

namespace surfaced::io {
namespace {

using Json = nlohmann::json;

/// The quarter turn that the writer gives a node for UpAxis::z, exactly.
bool is_up_rotation(const std::vector<double>& q) {
  return q == std::vector<double>{-std::sqrt(0.5), 0, 0, std::sqrt(0.5)};
}

Affine rotation(const std::vector<double>& q) {
  const double x = q[0];
  const double y = q[1];
  const double z = q[2];
  const double w = q[3];
  return {{{{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)},
            {2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)},
            {2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)}}},
          {}};
}

}  // namespace

Affine transform_of(const GltfDocument& document, const Json& node) {
  Affine result;
  if (const Json& matrix = document.member(node, "matrix"); !matrix.is_null()) {
    const std::vector<double> m = document.numbers(matrix, 16, "matrix");
    for (std::size_t r = 0; r < 3; ++r) {
      result.rows[r] = {m[r], m[4 + r], m[8 + r]};
      result.shift[r] = m[12 + r];
    }
    return result;
  }
  if (const Json& scale = document.member(node, "scale"); !scale.is_null()) {
    const std::vector<double> s = document.numbers(scale, 3, "scale");
    for (std::size_t r = 0; r < 3; ++r) result.rows[r][r] = s[r];
  }
  bool up = false;
  if (const Json& turn = document.member(node, "rotation"); !turn.is_null()) {
    const std::vector<double> q = document.numbers(turn, 4, "rotation");
    up = is_up_rotation(q);
    if (!up) result = rotation(q).after(result);
  }
  if (const Json& translation = document.member(node, "translation"); !translation.is_null()) {
    const std::vector<double> t = document.numbers(translation, 3, "translation");
    result.shift = up ? Point3{t[0], -t[2], t[1]} : Point3{t[0], t[1], t[2]};
  }
  return result;
}

}  // namespace surfaced::io
