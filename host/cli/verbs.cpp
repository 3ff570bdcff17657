#include "host/cli/verbs.h"

namespace stria {

std::vector<std::unique_ptr<Verb>> all_verbs() {
    std::vector<std::unique_ptr<Verb>> verbs;
    verbs.push_back(make_demo_verb());
    verbs.push_back(make_simulate_verb());
    verbs.push_back(make_advise_verb());
    verbs.push_back(make_devices_verb());
    verbs.push_back(make_info_verb());
    verbs.push_back(make_features_verb());
    verbs.push_back(make_calibrate_board_verb());
    verbs.push_back(make_calibrate_camera_verb());
    verbs.push_back(make_calibrate_sheet_verb());
    verbs.push_back(make_calibrate_plane_verb());
    verbs.push_back(make_calibrate_clock_verb());
    verbs.push_back(make_calibrate_scanner_verb());
    verbs.push_back(make_scan_verb());
    verbs.push_back(make_range_verb());
    verbs.push_back(make_register_verb());
    verbs.push_back(make_replay_verb());
    verbs.push_back(make_stripe_verb());
    verbs.push_back(make_fuse_verb());
    verbs.push_back(make_mesh_info_verb());
    verbs.push_back(make_mesh_compare_verb());
    verbs.push_back(make_mesh_convert_verb());
    verbs.push_back(make_verify_sphere_verb());
    verbs.push_back(make_verify_bar_verb());
    verbs.push_back(make_verify_plane_verb());
    verbs.push_back(make_verify_length_verb());
    verbs.push_back(make_verify_profile_verb());
    verbs.push_back(make_report_verb());
    return verbs;
}

}  // namespace stria
