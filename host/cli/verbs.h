#pragma once
#include <memory>

#include "host/cli/command.h"

/// One maker a verb, each in its own file verb_NAME.cpp; verbs.cpp lists them in --help's order.
namespace stria {

std::unique_ptr<Verb> make_demo_verb();
std::unique_ptr<Verb> make_simulate_verb();
std::unique_ptr<Verb> make_advise_verb();
std::unique_ptr<Verb> make_calibrate_board_verb();
std::unique_ptr<Verb> make_calibrate_camera_verb();
std::unique_ptr<Verb> make_calibrate_sheet_verb();
std::unique_ptr<Verb> make_calibrate_plane_verb();
std::unique_ptr<Verb> make_calibrate_clock_verb();
std::unique_ptr<Verb> make_calibrate_scanner_verb();
std::unique_ptr<Verb> make_scan_verb();
std::unique_ptr<Verb> make_range_verb();
std::unique_ptr<Verb> make_register_verb();
std::unique_ptr<Verb> make_replay_verb();
std::unique_ptr<Verb> make_stripe_verb();
std::unique_ptr<Verb> make_devices_verb();
std::unique_ptr<Verb> make_info_verb();
std::unique_ptr<Verb> make_features_verb();
std::unique_ptr<Verb> make_fuse_verb();
std::unique_ptr<Verb> make_mesh_info_verb();
std::unique_ptr<Verb> make_mesh_compare_verb();
std::unique_ptr<Verb> make_mesh_convert_verb();
std::unique_ptr<Verb> make_verify_sphere_verb();
std::unique_ptr<Verb> make_verify_bar_verb();
std::unique_ptr<Verb> make_verify_plane_verb();
std::unique_ptr<Verb> make_verify_length_verb();
std::unique_ptr<Verb> make_verify_profile_verb();
std::unique_ptr<Verb> make_report_verb();

}  // namespace stria
