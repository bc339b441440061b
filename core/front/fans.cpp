// SPDX-License-Identifier: GPL-3.0-or-later
#include "front/fans.hpp"

#include <algorithm>
#include <bit>
#include <numeric>

namespace surfaced::front {

namespace {

/// So many are searched one after the other.
constexpr std::size_t kFewWedges = 24;

bool erase_from(std::vector<std::uint32_t>& list, std::uint32_t vertex) {
  const auto at = std::ranges::find(list, vertex);
  if (at == list.end()) return false;
  *at = list.back();
  list.pop_back();
  return true;
}

std::vector<std::uint32_t> order_by(std::span<const Wedge> wedges, std::uint32_t Wedge::*end) {
  std::vector<std::uint32_t> order(wedges.size());
  std::iota(order.begin(), order.end(), 0U);
  std::ranges::stable_sort(order, {}, [&](std::uint32_t i) { return wedges[i].*end; });
  return order;
}

const Wedge* wedge_at(std::span<const Wedge> wedges, const std::vector<std::uint32_t>& order, std::uint32_t Wedge::*end,
                      std::uint32_t vertex) {
  if (order.empty()) {
    const auto at = std::ranges::find(wedges, vertex, end);
    return at == wedges.end() ? nullptr : &*at;
  }
  const auto at = std::ranges::lower_bound(order, vertex, {}, [&](std::uint32_t i) { return wedges[i].*end; });
  return at == order.end() || wedges[*at].*end != vertex ? nullptr : &wedges[*at];
}

}  // namespace

WedgeEnds::WedgeEnds(std::span<const Wedge> wedges) : wedges_(wedges) {
  if (wedges.size() <= kFewWedges) return;
  by_first_ = order_by(wedges, &Wedge::first);
  by_second_ = order_by(wedges, &Wedge::second);
}

const Wedge* WedgeEnds::from(std::uint32_t first) const { return wedge_at(wedges_, by_first_, &Wedge::first, first); }
const Wedge* WedgeEnds::to(std::uint32_t second) const { return wedge_at(wedges_, by_second_, &Wedge::second, second); }

OpenEnds::OpenEnds(std::span<const Wedge> wedges) {
  const WedgeEnds ends(wedges);
  for (const Wedge& w : wedges) {
    if (ends.to(w.first) == nullptr) first_.push_back(w.first);
    if (ends.from(w.second) == nullptr) second_.push_back(w.second);
  }
}

void OpenEnds::add(const Wedge& wedge) {
  if (!erase_from(second_, wedge.first)) first_.push_back(wedge.first);
  if (!erase_from(first_, wedge.second)) second_.push_back(wedge.second);
}

void OpenEnds::remove(const Wedge& wedge) {
  if (!erase_from(first_, wedge.first)) second_.push_back(wedge.first);
  if (!erase_from(second_, wedge.second)) first_.push_back(wedge.second);
}

Fans::Fans(const LocalStars& stars, FaceMasks faces)
    : stars_(stars), masks_(std::move(faces)), own_of_(stars.points(), kNoVertex) {
  std::size_t corners = 0;
  for (std::uint32_t v = 0; v < points(); ++v) {
    const auto count = static_cast<std::size_t>(std::popcount(masks_[v]));
    corners += count;
    if (count < stars_.triangles(v) || !stars_.closed(v)) own(v);
  }
  face_count_ = corners / 3;
}

template <class Visit>
void Fans::visit_settled(std::uint32_t v, Visit&& visit) const {
  const auto star = stars_.star(v);
  for (std::uint32_t mask = masks_[v]; mask != 0; mask &= mask - 1) {
    const auto i = static_cast<std::size_t>(std::countr_zero(mask));
    visit(Wedge{star[i], star[i + 1 < star.size() ? i + 1 : 0]});
  }
}

std::vector<Wedge>& Fans::own(std::uint32_t v) {
  if (own_of_[v] == kNoVertex) {
    own_of_[v] = static_cast<std::uint32_t>(own_.size());
    owners_.push_back(v);
    std::vector<Wedge>& list = own_.emplace_back();
    visit_settled(v, [&](const Wedge& w) { list.push_back(w); });
  }
  return own_[own_of_[v]];
}

std::span<const Wedge> Fans::wedges(std::uint32_t v) const {
  if (own_of_[v] != kNoVertex) return own_[own_of_[v]];
  copy_wedges(v, seen_);
  return seen_;
}

void Fans::copy_wedges(std::uint32_t v, std::vector<Wedge>& wedges) const {
  wedges.clear();
  if (own_of_[v] != kNoVertex) {
    const std::vector<Wedge>& list = own_[own_of_[v]];
    wedges.assign(list.begin(), list.end());
    return;
  }
  visit_settled(v, [&](const Wedge& w) { wedges.push_back(w); });
}

const OpenEnds* Fans::open_ends(std::uint32_t v) const {
  if (own_of_[v] == kNoVertex || own_[own_of_[v]].size() <= kFewWedges) return nullptr;
  // None of a star that was as large from the beginning.
  const auto ends = ends_of_.find(own_of_[v]);
  return ends == ends_of_.end() ? nullptr : &ends->second;
}

std::uint32_t Fans::apex(Edge e) const {
  if (own_of_[e.from] != kNoVertex) {
    for (const Wedge& w : own_[own_of_[e.from]]) {
      if (w.first == e.to) return w.second;
    }
    return kNoVertex;
  }
  std::uint32_t found = kNoVertex;
  visit_settled(e.from, [&](const Wedge& w) {
    if (w.first == e.to) found = w.second;
  });
  return found;
}

Around Fans::around(std::uint32_t v) const {
  if (own_of_[v] == kNoVertex) return masks_[v] == 0 ? Around::nothing : Around::closed;
  const std::vector<Wedge>& list = own_[own_of_[v]];
  if (list.empty()) return Around::nothing;
  if (const OpenEnds* ends = open_ends(v)) return ends->first().empty() ? Around::closed : Around::open;
  const WedgeEnds ends(list);
  const bool closed = std::ranges::all_of(list, [&](const Wedge& w) { return ends.to(w.first) != nullptr; });
  return closed ? Around::closed : Around::open;
}

std::vector<std::vector<Wedge>> Fans::fans_at(std::uint32_t v) const {
  const auto list = wedges(v);
  const WedgeEnds ends(list);
  std::vector<bool> taken(list.size(), false);
  std::vector<std::vector<Wedge>> all;
  for (std::size_t i = 0; i < list.size(); ++i) {
    if (taken[i]) continue;
    std::vector<Wedge>& fan = all.emplace_back();
    const auto take = [&](const Wedge* w) {
      const auto number = w == nullptr ? list.size() : static_cast<std::size_t>(w - list.data());
      if (number == list.size() || taken[number]) return;
      taken[number] = true;
      fan.push_back(*w);
    };
    take(&list[i]);
    // No directed edge has two faces: every wedge has one after it and one before it at most.
    for (std::size_t k = 0; k < fan.size(); ++k) {
      const Wedge w = fan[k];
      take(ends.from(w.second));
      take(ends.to(w.first));
    }
  }
  return all;
}

std::size_t Fans::fans(std::uint32_t v) const { return fans_at(v).size(); }

std::vector<Wedge> Fans::smallest_fan(std::uint32_t v) const {
  auto all = fans_at(v);
  const auto less = [](const Wedge& a, const Wedge& b) {
    return a.first != b.first ? a.first < b.first : a.second < b.second;
  };
  for (auto& fan : all) std::ranges::sort(fan, less);
  return *std::ranges::min_element(all, [&](const auto& a, const auto& b) {
    return a.size() != b.size() ? a.size() < b.size() : less(a.front(), b.front());
  });
}

void Fans::link(const Face& f) {
  for (std::size_t i = 0; i < 3; ++i) {
    const Wedge wedge{f[(i + 1) % 3], f[(i + 2) % 3]};
    std::vector<Wedge>& list = own(f[i]);
    const auto ends = ends_of_.find(own_of_[f[i]]);
    list.push_back(wedge);
    if (ends != ends_of_.end()) {
      ends->second.add(wedge);
    } else if (list.size() > kFewWedges) {
      ends_of_.emplace(own_of_[f[i]], OpenEnds(list));
    }
  }
  ++face_count_;
}

void Fans::unlink(const Face& f) {
  for (std::size_t i = 0; i < 3; ++i) {
    const Wedge wedge{f[(i + 1) % 3], f[(i + 2) % 3]};
    std::vector<Wedge>& list = own(f[i]);
    if (const auto ends = ends_of_.find(own_of_[f[i]]); ends != ends_of_.end()) ends->second.remove(wedge);
    list.erase(std::ranges::find(list, wedge));
  }
  --face_count_;
}

void Fans::add(const Face& face) {
  link(face);
  journal_.push_back({face, true});
}

void Fans::remove(const Face& face) {
  unlink(face);
  journal_.push_back({face, false});
}

void Fans::undo(std::size_t mark) {
  while (journal_.size() > mark) {
    const Change change = journal_.back();
    journal_.pop_back();
    change.added ? unlink(change.face) : link(change.face);
  }
}

std::vector<std::uint32_t> Fans::unsettled() const {
  std::vector<std::uint32_t> list = owners_;
  std::ranges::sort(list);
  return list;
}

std::vector<Triangle> Fans::triangles() const {
  std::vector<Triangle> all;
  all.reserve(face_count_);
  std::vector<Triangle> here;
  for (std::uint32_t v = 0; v < points(); ++v) {
    here.clear();
    for (const Wedge& w : wedges(v)) {
      if (v < w.first && v < w.second) here.push_back({VertexIndex(v), VertexIndex(w.first), VertexIndex(w.second)});
    }
    std::ranges::sort(here);
    all.insert(all.end(), here.begin(), here.end());
  }
  return all;
}

}  // namespace surfaced::front
