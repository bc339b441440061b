// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "base/base.hpp"
#include "jobs/sqlite/database.hpp"

namespace surfaced::sqlite {

/// What SQLite threw as a value: storage_full, not_ready (somebody else holds the file), or internal_error.
Error store_error(const SqliteError& error);

/// The wall of this folder: what SQLite throws becomes a value.
template <class Work>
auto guarded(const Work& work) -> decltype(work()) {
  try {
    return work();
  } catch (const SqliteError& error) {
    return store_error(error);
  }
}

}  // namespace surfaced::sqlite
