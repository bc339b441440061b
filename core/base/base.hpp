// SPDX-License-Identifier: GPL-3.0-or-later
// What every room stands on: errors as values, typed indices, points, and the context of a run.
#pragma once

#include "base/context.hpp"
#include "base/error.hpp"
#include "base/geometry.hpp"
#include "base/index.hpp"
