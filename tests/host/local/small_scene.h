#pragma once
#include "firmware/core/scan_plan.h"
#include "sim/scene.h"

namespace stria {

/// The built-in scene through a camera of an eighth of its pixels, so that a sweep takes a moment.
inline Scene small_scene() {
    Scene scene = built_in_scene();
    CameraModel& camera = scene.channel.camera;
    constexpr int kShrink = 8;
    camera.width /= kShrink;
    camera.height /= kShrink;
    camera.fx /= kShrink;
    camera.fy /= kShrink;
    camera.cx = (camera.cx + 0.5) / kShrink - 0.5;
    camera.cy = (camera.cy + 0.5) / kShrink - 0.5;
    scene.channel.sheet.waist_sigma_mm *= kShrink;  // as many pixels as before
    return scene;
}

/// Across the whole travel in some three hundred frames.
inline ScanPlan small_sweep(const Scene& scene) {
    ScanPlan plan;
    plan.mode = StripeMode::spacetime;
    plan.from = scene.axis.min;
    plan.to = scene.axis.max;
    plan.step = (plan.to - plan.from) / 320;
    plan.off_frames = 2;
    return plan;
}

}  // namespace stria
