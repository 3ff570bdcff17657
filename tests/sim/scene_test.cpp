#include "sim/scene.h"

#include <gtest/gtest.h>

#include "host/core/errors.h"
#include "host/io/whole_file.h"
#include "tests/sim/sim_sweep.h"

namespace stria {
namespace {

std::string text_of(const std::string& name) { return read_whole_file(example_scene(name)); }

std::string replaced(std::string text, const std::string& what, const std::string& by) {
    const std::size_t at = text.find(what);
    EXPECT_NE(at, std::string::npos) << what;
    return at == std::string::npos ? text : text.replace(at, what.size(), by);
}

std::string complaint(const std::string& text) {
    try {
        (void)parse_scene(text, "scene.toml", "");
    } catch (const Error& error) {
        return error.what();
    }
    return "";
}

TEST(Scene, ExamplesAreReadAndWrittenBackUnchanged) {
    for (const char* name : {"swept.toml", "rail.toml", "turntable.toml"}) {
        const Scene scene = read_scene(example_scene(name));
        EXPECT_EQ(validate(scene), "") << name;
        const std::string once = format_scene(scene);
        const Scene again = parse_scene(once, name, "");
        EXPECT_EQ(format_scene(again), once) << name;
        EXPECT_EQ(again.objects.size(), scene.objects.size());
        EXPECT_EQ(again.views.size(), scene.views.size());
        EXPECT_NEAR((again.channel.sheet.apex - scene.channel.sheet.apex).norm(), 0, 1e-9);
    }
}

TEST(Scene, BuiltInSceneIsValidAndCanBeWritten) {
    EXPECT_EQ(validate(built_in_scene()), "");
    const Scene again = parse_scene(format_scene(built_in_scene()), "built-in", "");
    EXPECT_EQ(format_scene(again), format_scene(built_in_scene()));
}

TEST(Scene, APointAnywhereOnTheMirrorsAxisMeansTheSameMirror) {
    const Scene scene = built_in_scene();
    std::string moved = format_scene(scene);
    moved = replaced(moved, "point = [170, 0, -20]", "point = [170, 35, -20]");
    const Scene again = parse_scene(moved, "moved", "");
    EXPECT_NEAR((again.channel.axis.mirror.point - scene.channel.axis.mirror.point).norm(), 0,
                1e-9);
    const LaserSheet a = sheet_at(scene.channel, 0.1), b = sheet_at(again.channel, 0.1);
    EXPECT_NEAR(a.offset_mm, b.offset_mm, 1e-9);
    EXPECT_NEAR((a.normal - b.normal).norm(), 0, 1e-12);
}

TEST(Scene, UnknownKeysNameTheNearestKnownOne) {
    const std::string text = replaced(text_of("swept.toml"), "fan_rad", "fan_radd");
    const std::string why = complaint(text);
    EXPECT_NE(why.find("fan_rad"), std::string::npos) << why;
    const std::string extra = complaint(replaced(text_of("swept.toml"), "level =", "levels ="));
    EXPECT_NE(extra.find("level"), std::string::npos) << extra;
}

TEST(Scene, WrongValuesAreRefusedWithTheirBound) {
    const struct {
        const char* what;
        const char* by;
        const char* hint;
    } cases[] = {
        {"kind = \"swept\"", "kind = \"spun\"", "turntable"},
        {"albedo = 0.6", "albedo = 1.6", "albedo"},
        {"radius = 40", "radius = -40", "radius"},
        {"bits = 8", "bits = 7", "bits"},
        {"max_speed = 4", "max_speed = 0", "max_speed"},
        {"min = -0.16", "min = 0.16", "axis.min"},
        {"width = 800", "width = 80000", "width"},
        {"width = 800\nheight = 640", "width = 16000\nheight = 16000", "33554432"},
        {"max_speed = 4", "max_speed = 1e-9", "hour"},
        {"min = -0.16", "min = -inf", "finite"},
        {"shape = \"sphere\"", "shape = \"cube\"", "mesh"},
        {"hidden = [\"sphere\"]", "hidden = [\"spher\"]", "spher"},
        {"distortion = [-0.08,", "distortion = [", "5"},
        {"world_from_object = [1, 0, 0, -20", "world_from_object = [2, 0, 0, -20", "rigid"},
    };
    for (const auto& c : cases) {
        const std::string why = complaint(replaced(text_of("swept.toml"), c.what, c.by));
        EXPECT_NE(why.find(c.hint), std::string::npos) << c.by << ": " << why;
    }
}

TEST(Scene, EveryTruncationIsAnErrorOrAScene) {
    const std::string text = text_of("rail.toml");
    for (std::size_t size = 0; size < text.size(); size += 3) (void)complaint(text.substr(0, size));
}

TEST(Scene, MissingFilesAreNamed) {
    const std::string text = replaced(text_of("swept.toml"), "shape = \"sphere\"\nradius = 40",
                                      "shape = \"mesh\"\nfile = \"not_there.ply\"");
    const std::string why = complaint(text);
    EXPECT_NE(why.find("not_there.ply"), std::string::npos) << why;
}

TEST(Scene, ContentFromMemoryCannotBeWritten) {
    Scene scene = built_in_scene();
    scene.objects[0].texture_image = std::make_shared<const GreyImage>(4, 4);
    scene.objects[0].texture_size_mm = {10, 10};
    EXPECT_THROW((void)format_scene(scene), std::invalid_argument);
}

}  // namespace
}  // namespace stria
