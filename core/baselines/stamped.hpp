// SPDX-License-Identifier: GPL-3.0-or-later
// Private to the room: CGAL's structures without the order of addresses.
#pragma once

#include <CGAL/tags.h>

#include <cstddef>

namespace surfaced::baselines {

/// A vertex or cell that knows when it was made: handles then compare by that and not by address.
template <class Base>
class Stamped : public Base {
 public:
  using Base::Base;
  using Has_timestamp = CGAL::Tag_true;
  std::size_t time_stamp() const { return stamp_; }
  void set_time_stamp(std::size_t stamp) { stamp_ = stamp; }
  template <class Structure>
  struct Rebind_TDS {
    using Other = Stamped<typename Base::template Rebind_TDS<Structure>::Other>;
  };

 private:
  std::size_t stamp_ = static_cast<std::size_t>(-1);
};

}  // namespace surfaced::baselines
