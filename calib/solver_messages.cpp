#include "calib/solver_messages.h"

#include <glog/logging.h>

namespace stria {

void silence_solver_warnings() { FLAGS_minloglevel = google::GLOG_FATAL; }

}  // namespace stria
