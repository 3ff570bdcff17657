#pragma once
#include <Eigen/Core>
#include <string>
#include <vector>

#include "calib/linear_view.h"

namespace stria {

struct CoachOptions {
    ViewPlan plan;  ///< how each view is taken
    /// Distances (mm from the camera) between which points are to be measured; 0, 0: 0.8 and 1.25
    /// of where the sheet in the middle of the sweep meets the camera's axis.
    double near_mm = 0, far_mm = 0;
    /// Spacetime: a stripe point's sigma across the sheet does not depend on its distance, because
    /// the pulse lasts as long as the sheet is thick; it is plan.stripe_sigma_px in the middle.
    StripeMode mode = StripeMode::spatial;
    ScannerCalibrationOptions calibration;  ///< how far the machine may be from its drawing
};

/// What to do next, and what it would bring.
struct CoachAdvice {
    double sigma_now_mm = 0;   ///< rms over the volume, rigid motion taken out
    double sigma_then_mm = 0;  ///< after the view proposed
    std::string weakest;       ///< parameter that contributes most now, in words
    Rigid3 camera_from_board;  ///< the placement proposed, at s = 0
    std::string place;         ///< where to hold the board: "hold the board 430 mm away, ..."
    std::string text;          ///< that and what it would bring, for the person with the board
};

/// Tells a person where to hold the board next. What is known is kept as information about modes of
/// the drawing's uncertainty (drawing_covariance()); every view adds what its own Jacobian holds,
/// its board's pose free. Of a fixed library of placements (25 places in the image, 3 distances, 9
/// tilts) that one is proposed after which the points of the volume would be known best: the least
/// trace of their covariance (A-optimal design). First order throughout, so that it works from the
/// first view on, before anything can be solved.
class Coach {
  public:
    /// Throws stria::Error if the drawing's sheet never meets the field between the distances.
    Coach(const Board& board, const ScannerModel& drawing, const CoachOptions& options);

    /// Adds a view as measured; false if no picture of it shows the board or no stripe crosses it
    /// (nothing is added then).
    bool take(const CornerView& view);
    /// Whether a picture of the view shows the board and a stripe crosses it: take() would add it.
    bool can_use(const CornerView& view) const;
    /// Never proposes that placement again: a view there showed no usable board or stripe, or is
    /// kept from the solve to check it.
    void avoid(const Rigid3& camera_from_board);

    double sigma_mm() const;
    CoachAdvice advise() const;
    /// An SVG picture: the image with the outlines of the boards taken (grey) and of the one
    /// proposed (its first corner marked), and the distances beside it.
    std::string picture(const CoachAdvice& advice) const;

    const ScannerModel& model() const { return model_; }

  private:
    struct Placement {
        Rigid3 camera_from_board;
        Eigen::MatrixXd information;  ///< about the modes
    };
    std::vector<Rigid3> library() const;
    /// Linearises about a model from now on.
    void follow(const ScannerModel& model);
    ViewData data_of(const CornerView& view) const;
    bool is_avoided(const Rigid3& pose) const;
    std::string weakest() const;

    Board board_;
    ScannerModel model_;
    CoachOptions options_;
    Eigen::MatrixXd modes_;
    Eigen::MatrixXd information_;        ///< about the modes, prior included
    Eigen::MatrixXd moves_;              ///< of the volume's points by mode
    std::vector<Placement> placements_;  ///< those of the library that show board and stripe
    std::vector<Rigid3> taken_, avoided_;
};

/// Where a board is and how it stands, for people: "430 mm away, to the left and high, its right
/// side 35 deg farther".
std::string describe_placement(const CameraModel& camera, const Board& board,
                               const Rigid3& camera_from_board);

/// A parameter name (parameter_names()) in words: "focal length", "axis of the table" ...
std::string in_words(const std::string& parameter);

}  // namespace stria
