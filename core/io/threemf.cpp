// SPDX-License-Identifier: GPL-3.0-or-later
// 3MF core specification 1.3 (3MF Consortium): one mesh object in one build item. Written here and not by lib3mf 1.8.1,
// which writes six decimals and random identifiers (docs/DECISIONS.md); read as far as `measure` and the report need
// it.
#include <charconv>
#include <optional>

#include "io/decimal.hpp"
#include "io/formats.hpp"
#include "io/text.hpp"
#include "io/zip.hpp"

namespace surfaced::io {
namespace {

constexpr std::string_view kModelName = "3D/3dmodel.model";
constexpr std::string_view kOrigin = "<!-- origin ";

constexpr std::string_view kTypes =
    R"(<?xml version="1.0" encoding="UTF-8"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types"><Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/><Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/></Types>
)";
constexpr std::string_view kRelations =
    R"(<?xml version="1.0" encoding="UTF-8"?>
<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship Target="/3D/3dmodel.model" Id="rel0" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>
)";

std::string_view unit_text(Unit unit) {
  switch (unit) {
    case Unit::millimetre:
      return "millimeter";
    case Unit::centimetre:
      return "centimeter";
    case Unit::metre:
      return "meter";
    case Unit::inch:
      break;
  }
  return "inch";
}

std::string model_text(const TriangleMesh& mesh, const Point3& origin, Unit unit) {
  std::string text = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<model unit=\"" + std::string(unit_text(unit)) +
                     "\" xml:lang=\"en-US\" xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\">\n";
  if (origin != Point3{}) {
    text += kOrigin;
    for (const double x : origin) {
      append_decimal(text, x);
      text += ' ';
    }
    text += "-->\n";
  }
  text += "<metadata name=\"Application\">surfaced " SURFACED_VERSION
          "</metadata>\n<resources><object id=\"1\" type=\"model\"><mesh><vertices>\n";
  for (const Point3& p : mesh.positions) {
    const std::array<float, 3> local = local_position(p, origin);
    for (std::size_t axis = 0; axis < 3; ++axis) {
      text += std::array{"<vertex x=\"", "\" y=\"", "\" z=\""}.at(axis);
      append_decimal(text, local.at(axis));
    }
    text += "\"/>\n";
  }
  text += "</vertices><triangles>\n";
  for (const Triangle& t : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      text += std::array{"<triangle v1=\"", "\" v2=\"", "\" v3=\""}.at(k);
      append_decimal(text, t[k].value);
    }
    text += "\"/>\n";
  }
  return text + "</triangles></mesh></object></resources>\n<build><item objectid=\"1\"/></build>\n</model>\n";
}

/// Walks the tags of a model that holds one mesh; everything else is looked at only to refuse it.
class ModelReader {
 public:
  ModelReader(std::string_view text, std::string_view name) : text_(text), name_(name) {}

  Result<TriangleMesh> run() {
    for (std::size_t at = text_.find('<'); at != std::string_view::npos; at = text_.find('<', at)) {
      const std::size_t end = std::min(text_.find('>', at), text_.size());
      if (Status status = read(text_.substr(at, end - at)); !status) return std::move(status).error();
      at = end;
    }
    if (objects_ != 1) return unsupported(std::to_string(objects_) + " mesh objects; one is read");
    if (mesh_.positions.empty()) return Error{ErrorCode::empty_input, std::string(name_) + ": the 3MF has no vertices"};
    return std::move(mesh_);
  }

  std::size_t degenerate = 0;

 private:
  Error unsupported(const std::string& what) const {
    return {ErrorCode::unsupported_feature, std::string(name_) + ": " + what};
  }

  Status read(std::string_view tag) {
    if (tag.starts_with("<vertex ")) return read_vertex(tag);
    if (tag.starts_with("<triangle ")) return read_triangle(tag);
    if (tag.starts_with("<component ") || tag.find(" transform=") != std::string_view::npos) {
      return unsupported("components and transforms of a 3MF");
    }
    if (tag == "<mesh") ++objects_;
    if (tag.starts_with(kOrigin)) read_origin(tag.substr(kOrigin.size()));
    return Done{};
  }

  void read_origin(std::string_view text) {
    const char* at = text.data();
    for (double& x : origin_) {
      const auto [stop, problem] = std::from_chars(at, text.data() + text.size(), x);
      if (problem != std::errc{} || stop == text.data() + text.size()) {
        origin_ = {};
        return;
      }
      at = stop + 1;
    }
  }

  template <class T>
  bool attribute(std::string_view tag, std::string_view key, T& value) const {
    const std::size_t at = tag.find(key);
    if (at == std::string_view::npos) return false;
    const char* const end = tag.data() + tag.size();
    const auto [stop, problem] = std::from_chars(tag.data() + at + key.size(), end, value);
    return problem == std::errc{} && stop != end && *stop == '"';
  }

  Error malformed(std::string_view tag) const {
    return {ErrorCode::malformed_input, std::string(name_) + ": " + in_quotes(tag)};
  }

  Status read_vertex(std::string_view tag) {
    std::array<float, 3> local{};
    if (!attribute(tag, " x=\"", local[0]) || !attribute(tag, " y=\"", local[1]) || !attribute(tag, " z=\"", local[2]))
      return malformed(tag);
    Point3 p;
    const bool shifted = origin_ != Point3{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      p[axis] = shifted ? static_cast<double>(local.at(axis)) + origin_[axis] : static_cast<double>(local.at(axis));
    }
    mesh_.positions.push_back(p);
    return Done{};
  }

  Status read_triangle(std::string_view tag) {
    std::array<std::uint32_t, 3> v{};
    if (!attribute(tag, " v1=\"", v[0]) || !attribute(tag, " v2=\"", v[1]) || !attribute(tag, " v3=\"", v[2]))
      return malformed(tag);
    for (const std::uint32_t corner : v) {
      if (corner >= mesh_.positions.size()) return malformed(tag);
    }
    if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0]) {
      ++degenerate;
    } else {
      mesh_.triangles.push_back({VertexIndex(v[0]), VertexIndex(v[1]), VertexIndex(v[2])});
    }
    return Done{};
  }

  std::string_view text_;
  std::string_view name_;
  TriangleMesh mesh_;
  Point3 origin_{};
  std::size_t objects_ = 0;
};

}  // namespace

Result<Bytes> write_3mf_mesh(const TriangleMesh& mesh, const EncodeOptions& options) {
  if (mesh.triangles.empty()) return Error{ErrorCode::method_failed, "the mesh has no triangles; 3MF cannot hold that"};
  return write_zip({{"[Content_Types].xml", std::string(kTypes)},
                    {"_rels/.rels", std::string(kRelations)},
                    {std::string(kModelName), model_text(mesh, float_origin_of(mesh.positions), options.unit)}});
}

Result<TriangleMesh> read_3mf_mesh(std::span<const std::byte> bytes, std::string_view name,
                                   std::vector<std::string>& warnings) {
  const Result<std::string> text = read_zip_entry(bytes, ".model", name);
  if (!text) return text.error();
  ModelReader reader(*text, name);
  Result<TriangleMesh> mesh = reader.run();
  warn_of_degenerate(reader.degenerate, warnings);
  return mesh;
}

}  // namespace surfaced::io
