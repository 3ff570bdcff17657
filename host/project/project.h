#pragma once
#include <string>
#include <vector>

namespace stria {

/// A folder that holds everything about one part:
///   project.toml  scanner.toml  poses.toml  model.ply  model.glb  report.html
///   check.toml  scans/0001/recording.stria  scans/0001/range.ply  scans/0001/scan.toml ...
struct Project {
    std::string folder;
    std::string name;           ///< of the part, as project.toml has it
    std::string stria_version;  ///< of the program that made it

    std::string file(const std::string& relative) const { return folder + "/" + relative; }
    std::string scanner() const { return file("scanner.toml"); }
    std::string poses() const { return file("poses.toml"); }
    std::string model_ply() const { return file("model.ply"); }
    std::string model_glb() const { return file("model.glb"); }
    std::string check() const { return file("check.toml"); }  ///< reference of drift checks
    std::string report() const { return file("report.html"); }
    std::string scans() const { return file("scans"); }
};

/// One scan's folder inside a project.
struct ScanFolder {
    std::string folder;
    std::string name;  ///< "0001"

    std::string recording() const { return folder + "/recording.stria"; }
    std::string range() const { return folder + "/range.ply"; }
    std::string notes() const { return folder + "/scan.toml"; }
};

/// True if the folder holds a project.toml.
bool is_project(const std::string& folder);

/// Makes the folder (its parents must exist) with project.toml and scans/. An empty folder that
/// exists is taken; one with other content is refused with a FileError, so is a project.
/// @param name  empty: the folder's own name
Project create_project(const std::string& folder, const std::string& name = "");
/// Reads project.toml. Throws FileError.
Project open_project(const std::string& folder);
/// The project there, made if the folder does not exist or is empty.
Project open_or_create_project(const std::string& folder);

/// The scan folders in ascending order of their numbers. Throws FileError for a folder in scans/
/// whose name is no number.
std::vector<ScanFolder> list_scans(const Project& project);
/// Makes the folder of the next scan: one above the greatest number there.
ScanFolder make_next_scan(const Project& project);

/// What a SCAN argument stands for. Empty paths: there is none.
struct ScanSource {
    std::string name;       ///< for messages and poses: the path of the folder or file
    std::string recording;  ///< a .stria file
    std::string range;      ///< a range PLY
    std::string points;     ///< points without grid: PLY, PCD, XYZ, CSV
};

/// The scans that the arguments name: a recording (.stria), a range PLY, points, a scan folder, or
/// a project, which stands for all its scans. Throws FileError for what does not exist, a folder
/// that is neither, a scan folder or project without scans, and a scan that is named twice.
std::vector<ScanSource> resolve_scans(const std::vector<std::string>& arguments);

/// `file` as a name relative to the folder of `beside`: what poses.toml holds of a scan.
std::string relative_name(const std::string& file, const std::string& beside);

}  // namespace stria
