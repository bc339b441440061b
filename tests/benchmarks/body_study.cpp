// SPDX-License-Identifier: GPL-3.0-or-later
// How often minimum-boundary makes the right body of random points with noise: volume, genus, warnings.
//   body_study FIRST_SEED LAST_SEED [SHAPE|all [POINTS,... [NOISE,... [best|fast|paper]]]]
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

#include "minimum_boundary/minimum_boundary.hpp"
#include "support/known_bodies.hpp"

namespace {

using surfaced::testing::KnownBody;

/// A volume beyond these shares of the truth is a wrong body; below the second one a hollow cage.
constexpr double kWrongVolume = 0.25;
constexpr double kHollow = 0.5;

struct Tally {
  int runs = 0;
  int wrong_volume = 0;
  int wrong_volume_silent = 0;
  int hollow = 0;
  int hollow_silent = 0;
  int wrong_topology = 0;
  int wrong_silent = 0;
  int right_warned = 0;
};

void add(Tally& sum, const Tally& t) {
  sum.runs += t.runs;
  sum.wrong_volume += t.wrong_volume;
  sum.wrong_volume_silent += t.wrong_volume_silent;
  sum.hollow += t.hollow;
  sum.hollow_silent += t.hollow_silent;
  sum.wrong_topology += t.wrong_topology;
  sum.wrong_silent += t.wrong_silent;
  sum.right_warned += t.right_warned;
}

void print(const std::string& title, const Tally& t) {
  std::printf(
      "%-34s %4d runs: volume wrong %3d (silent %d), hollow %3d (silent %d); topology wrong %3d (silent %d); right "
      "warned %d\n",
      title.c_str(), t.runs, t.wrong_volume, t.wrong_volume_silent, t.hollow, t.hollow_silent, t.wrong_topology,
      t.wrong_silent, t.right_warned);
}

std::vector<double> numbers(const std::string& text) {
  std::vector<double> list;
  std::istringstream stream(text);
  for (std::string part; std::getline(stream, part, ',');) list.push_back(std::stod(part));
  return list;
}

void run_one(const KnownBody& body, std::size_t n, double noise, std::uint32_t seed,
             const surfaced::MinimumBoundaryParameters& parameters, Tally& tally) {
  surfaced::RawCloud raw;
  raw.positions = surfaced::testing::points_of(body, n, noise, seed);
  surfaced::Context context(1);
  const auto result = surfaced::minimum_boundary(*surfaced::make_cloud(raw), parameters, context);
  ++tally.runs;
  if (!result) {
    std::printf("FAILED %s\n", result.error().detail.c_str());
    return;
  }
  const auto& s = result->statistics;
  const double share = surfaced::testing::volume_of(result->mesh) / body.volume;
  const bool warned = !result->warnings.empty();
  const bool wrong_volume = std::abs(share - 1) > kWrongVolume;
  const bool wrong_topology = s.genus != body.genus || s.components != 1;
  if (wrong_volume) ++tally.wrong_volume;
  if (wrong_volume && !warned) ++tally.wrong_volume_silent;
  if (share < kHollow) ++tally.hollow;
  if (share < kHollow && !warned) ++tally.hollow_silent;
  if (wrong_topology) ++tally.wrong_topology;
  if (wrong_topology && !warned) ++tally.wrong_silent;
  if (!wrong_topology && !wrong_volume && warned) ++tally.right_warned;
  if (wrong_volume || wrong_topology) {
    std::printf("  %s %zu %.2f seed %u: volume %.3f genus %ld comps %zu int %zu sum %.2f chosen %s %s\n",
                body.name.c_str(), n, noise, seed, share, static_cast<long>(s.genus), s.components, s.interior_vertices,
                s.sum_lambda, s.chosen_candidate.c_str(),
                warned ? result->warnings.front().substr(0, 40).c_str() : "SILENT");
  }
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> args(argv + 1, argv + argc);
  if (args.size() < 2) {
    std::cerr << "usage: body_study FIRST_SEED LAST_SEED [SHAPE|all [POINTS,... [NOISE,... [best|fast|paper]]]]\n";
    return 2;
  }
  const auto first = static_cast<std::uint32_t>(std::stoul(args[0]));
  const auto last = static_cast<std::uint32_t>(std::stoul(args[1]));
  const std::string shape = args.size() > 2 ? args[2] : "all";
  const std::vector<double> sizes = numbers(args.size() > 3 ? args[3] : "100,300,1000,3000");
  const std::vector<double> noises = numbers(args.size() > 4 ? args[4] : "0,0.1,0.2,0.35,0.5");
  surfaced::MinimumBoundaryParameters parameters;
  if (args.size() > 5 && args[5] == "fast") parameters.variant = surfaced::MinimumBoundaryParameters::Variant::fast;
  if (args.size() > 5 && args[5] == "paper") parameters.variant = surfaced::MinimumBoundaryParameters::Variant::paper;
  Tally all;
  const auto start = std::chrono::steady_clock::now();
  for (const KnownBody& body : surfaced::testing::known_bodies()) {
    if (shape != "all" && shape != body.name) continue;
    for (const double noise : noises) {
      Tally tally;
      for (const double n : sizes) {
        for (std::uint32_t seed = first; seed <= last; ++seed) {
          run_one(body, static_cast<std::size_t>(n), noise, seed, parameters, tally);
        }
      }
      print(body.name + ", noise " + std::to_string(noise).substr(0, 4), tally);
      add(all, tally);
    }
  }
  print("all", all);
  std::printf("%.1f s\n", std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  return 0;
}
