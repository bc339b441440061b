// SPDX-License-Identifier: GPL-3.0-or-later
#include "hole_filling/boundary_loops.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <map>
#include <unordered_map>

namespace surfaced::filling {
namespace {

using Chain = std::vector<HalfEdgeIndex>;

std::string text_of(const Point3& p) {
  std::array<char, 96> text{};
  std::snprintf(text.data(), text.size(), "(%.9g, %.9g, %.9g)", p[0], p[1], p[2]);
  return text.data();
}

class Tracing {
 public:
  explicit Tracing(const TriangleMesh& mesh)
      : mesh_(mesh), half_edges_(mesh.triangles, mesh.positions.size()), seen_(3 * mesh.triangles.size(), false) {}

  std::vector<BoundaryLoop> operator()() {
    for (std::size_t h = 0; h < seen_.size(); ++h) {
      if (is_open(HalfEdgeIndex(h)) && !seen_[h]) trace(HalfEdgeIndex(h));
    }
    for (const Chain& chain : chains_) add_loop(chain);
    name_touching_loops();
    std::ranges::sort(loops_, {}, [](const BoundaryLoop& loop) { return loop.corners; });
    return std::move(loops_);
  }

 private:
  VertexIndex tail(HalfEdgeIndex h) const { return mesh_.triangles[h / 3][h % 3]; }
  VertexIndex head(HalfEdgeIndex h) const { return tail(HalfEdges::next(h)); }
  bool is_open(HalfEdgeIndex h) const { return half_edges_.uses(half_edges_.edge_of(h)) == 1; }

  /// The open edge that leaves the head of h within the same fan; not valid if the fan ends at an edge of more than two
  /// triangles or of two that disagree.
  HalfEdgeIndex next_in_fan(HalfEdgeIndex h) const {
    HalfEdgeIndex g = HalfEdges::next(h);
    while (g.valid() && !is_open(g)) {
      const HalfEdgeIndex mate = half_edges_.mate(g);
      g = mate.valid() ? HalfEdges::next(mate) : HalfEdgeIndex();
    }
    return g;
  }

  /// Follows the boundary through fans and cuts off every part that comes back to a vertex.
  void trace(HalfEdgeIndex start) {
    Chain chain;
    std::unordered_map<std::uint32_t, std::size_t> place;
    for (HalfEdgeIndex h = start; h.valid() && !seen_[h]; h = next_in_fan(h)) {
      const auto [at, is_new] = place.emplace(tail(h).value, chain.size());
      if (!is_new) {
        const std::size_t from = at->second;
        chains_.emplace_back(chain.begin() + static_cast<std::ptrdiff_t>(from), chain.end());
        for (std::size_t i = from + 1; i < chain.size(); ++i) place.erase(tail(chain[i]).value);
        chain.resize(from);
      }
      seen_[h] = true;
      chain.push_back(h);
    }
    if (!chain.empty()) chains_.push_back(std::move(chain));
  }

  void add_loop(const Chain& chain) {
    BoundaryLoop loop;
    const auto least = std::ranges::min_element(chain, {}, [&](HalfEdgeIndex h) { return tail(h); });
    const auto n = static_cast<std::ptrdiff_t>(chain.size());
    // The loop runs against the mesh's half-edges: from the tail of `least` to the tail of the one before it.
    for (std::ptrdiff_t i = 0; i < n; ++i) {
      const HalfEdgeIndex corner = chain[static_cast<std::size_t>((least - chain.begin() - i + n) % n)];
      const HalfEdgeIndex edge = chain[static_cast<std::size_t>((least - chain.begin() - i - 1 + 2 * n) % n)];
      loop.corners.push_back(tail(corner));
      loop.beyond.push_back(tail(HalfEdges::previous(edge)));
      loop.behind.push_back(edge);
    }
    if (chain.size() < 3 || head(chain.back()) != tail(chain.front())) {
      loop.obstacle = "it runs into an edge of more than two triangles, or of two that disagree in orientation";
    }
    const std::size_t number = loops_.size();
    for (std::size_t i = 0; i < chain.size(); ++i) {
      const HalfEdgeIndex in = chain[(i + chain.size() - 1) % chain.size()];
      at_vertex_[tail(chain[i]).value].push_back({number, in, chain[i]});
    }
    loops_.push_back(std::move(loop));
  }

  /// A place where a loop passes a vertex: over one fan and on to the next.
  struct Passage {
    std::size_t loop;
    HalfEdgeIndex in;
    HalfEdgeIndex out;
  };

  /// The patches of the loops join the fans at a vertex; unless they join them all to one umbrella, the loops stay
  /// open.
  void name_touching_loops() {
    for (const auto& [vertex, passages] : at_vertex_) {
      if (passages.size() < 2) continue;
      std::size_t reached = 0;
      HalfEdgeIndex fan = passages.front().out;
      do {
        const auto onward = std::ranges::find_if(passages, [&](const Passage& p) { return next_in_fan(p.in) == fan; });
        if (onward == passages.end()) break;
        fan = onward->out;
      } while (++reached < passages.size() && fan != passages.front().out);
      if (reached == passages.size() && fan == passages.front().out) continue;
      for (const Passage& p : passages) {
        loops_[p.loop].obstacle = "it touches another part of the mesh in " + text_of(mesh_.positions[vertex]);
      }
    }
  }

  const TriangleMesh& mesh_;
  HalfEdges half_edges_;
  std::vector<bool> seen_;
  std::vector<Chain> chains_;
  std::vector<BoundaryLoop> loops_;
  std::map<std::uint32_t, std::vector<Passage>> at_vertex_;
};

}  // namespace

std::vector<BoundaryLoop> boundary_loops(const TriangleMesh& mesh) { return Tracing(mesh)(); }

}  // namespace surfaced::filling
