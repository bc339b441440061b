// SPDX-License-Identifier: GPL-3.0-or-later
// Clients that take nothing of their answers: who is ended, and when.
#include "http/unsent.hpp"

#include <gtest/gtest.h>

namespace surfaced::http {
namespace {

using std::chrono::milliseconds;

constexpr Unsent::Limits kLimits{100, 300, milliseconds(1000)};

class UnsentTest : public ::testing::Test {
 protected:
  Unsent::Clock::time_point at(int milliseconds_later) const { return start_ + milliseconds(milliseconds_later); }
  const Unsent::Clock::time_point start_ = Unsent::Clock::now();
  Unsent unsent_{kLimits};
};

TEST_F(UnsentTest, nobody_is_ended_while_there_is_room) {
  unsent_.note(1, {0, 60, 0}, at(0));
  unsent_.note(2, {40, 0, 0}, at(0));
  EXPECT_EQ(unsent_.bytes(), 100U);
  EXPECT_FALSE(unsent_.is_short());
  EXPECT_FALSE(unsent_.overdue(at(1'000'000)));
}

TEST_F(UnsentTest, who_has_taken_nothing_for_the_longest_is_ended_first_and_not_at_once) {
  unsent_.note(1, {0, 60, 0}, at(0));
  unsent_.note(2, {0, 60, 0}, at(10));
  EXPECT_TRUE(unsent_.is_short());
  EXPECT_FALSE(unsent_.overdue(at(999)));
  EXPECT_EQ(unsent_.overdue(at(1000)), 1U);
  unsent_.note(1, {0, 60, 5}, at(1000));
  EXPECT_FALSE(unsent_.overdue(at(1000))) << "the first has taken something";
  EXPECT_EQ(unsent_.overdue(at(1010)), 2U);
  unsent_.forget(2);
  EXPECT_FALSE(unsent_.overdue(at(1'000'000)));
}

TEST_F(UnsentTest, memory_of_the_process_is_not_waited_for) {
  unsent_.note(1, {200, 0, 0}, at(0));
  unsent_.note(2, {200, 0, 0}, at(1));
  EXPECT_EQ(unsent_.overdue(at(1)), 1U);
  unsent_.forget(1);
  EXPECT_FALSE(unsent_.overdue(at(1)));
  unsent_.note(2, {0, 0, 400}, at(2));
  EXPECT_EQ(unsent_.bytes(), 0U);
  unsent_.forget(2);
}

}  // namespace
}  // namespace surfaced::http
