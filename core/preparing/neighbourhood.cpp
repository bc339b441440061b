#include "preparing/neighbourhood.hpp"

#include <algorithm>
#include <cmath>
#include <nanoflann.hpp>

#include "base/parallel.hpp"

namespace surfaced {
namespace preparing {
namespace {

/// What nanoflann asks of a set of points.
struct Adaptor {
  const std::vector<Point3>& positions;
  std::size_t kdtree_get_point_count() const { return positions.size(); }
  double kdtree_get_pt(std::size_t v, std::size_t axis) const { return positions[v][axis]; }
  template <class Box>
  bool kdtree_get_bbox(Box&) const {
    return false;
  }
};
using Tree =
    nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, Adaptor>, Adaptor, 3, std::uint32_t>;

}  // namespace

std::vector<double> mean_distances(const std::vector<Point3>& positions, std::size_t k, unsigned threads) {
  const Adaptor adaptor{positions};
  const Tree tree(3, adaptor, nanoflann::KDTreeSingleIndexAdaptorParams(10));
  std::vector<double> means(positions.size(), 0);
  parallel_ranges(threads, positions.size(), [&](std::size_t begin, std::size_t end) {
    std::vector<std::uint32_t> index(k + 1);
    std::vector<double> squared(k + 1);
    for (std::size_t v = begin; v < end; ++v) {
      const std::size_t found = tree.knnSearch(positions[v].data(), k + 1, index.data(), squared.data());
      double sum = 0;
      for (std::size_t i = 0; i < found; ++i) sum += std::sqrt(squared[i]);
      if (found > 1) means[v] = sum / static_cast<double>(found - 1);
    }
  });
  return means;
}

double median_of(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

}  // namespace preparing

double spacing_of(const std::vector<Point3>& positions, unsigned threads) {
  constexpr std::size_t kNeighbours = 6;
  return preparing::median_of(preparing::mean_distances(positions, kNeighbours, threads));
}

}  // namespace surfaced
