// SPDX-License-Identifier: GPL-3.0-or-later
// Private to the room: what a patch of surface looks like, in eight numbers (paper 3, §3.2).
#pragma once

#include <array>
#include <span>

#include "intrinsic_delaunay/local_shape.hpp"

namespace surfaced::idt {

/// f1..f8 of the paper, unit-free: mean curvatures times ε, Gaussian ones times ε². The quotients f5, f6, which divide
/// by values that may be 0, became spreads (max − min) / (|max| + |min| + 10⁻⁶).
using Signature = std::array<double, 8>;

Signature signature_of(std::span<const LocalShape::Curvature> curvatures, double epsilon);

/// Tanimoto's coefficient Σfg / (Σf² + Σg² − Σfg), which the printed denominator f + g − fg is that of: within
/// [−1/3, 1], and 1 only for equal signatures (two of zeros among them).
double similarity(const Signature& f, const Signature& g);

}  // namespace surfaced::idt
