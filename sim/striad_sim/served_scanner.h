#pragma once
#include "firmware/session/served_device.h"
#include "sim/simulated_scanner.h"

namespace stria {

/// A simulated scanner as a session serves it: it states its nominal model, its exposure starts
/// where the scene's sensor says, and the feature SceneView chooses the scene's view.
/// @param scanner  must outlive the session
/// @param threads  of the stripe analysis; the result does not depend on it
ServedDevice served_scanner(SimulatedScanner& scanner, int threads);

}  // namespace stria
