#pragma once

namespace stria {

/// Keeps Ceres' own lines off stderr, for a program whose messages say what came of a solve: it
/// warns of every step that it rejects on its way, and of every try that fails. Not for libraries
/// to call: it holds for the whole process.
void silence_solver_warnings();

}  // namespace stria
