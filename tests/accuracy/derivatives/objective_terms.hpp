// SPDX-License-Identifier: MIT
// A term of each kind of objective, with everything in it that has a derivative.
#pragma once

#include "tape/objective.hpp"

namespace table {

dqa::ObjectiveTerm term_of(dqa::ObjectiveKind kind);

}  // namespace table
