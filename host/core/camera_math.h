#pragma once
#include <cmath>

/// The lens model in templates, so that the same lines serve doubles and a solver's dual numbers.
namespace stria::camera_math {

/// Number of distortion coefficients used from a k1 k2 p1 p2 k3 k4 k5 k6 array: always pass 8,
/// the unused ones 0; brown5 is then rational8 with k4 = k5 = k6 = 0, and pinhole all zero.
/// Distorted (xd, yd) of the ideal image point (x, y) = (X/Z, Y/Z); OpenCV's formulas.
template <typename T>
void distort(const T* d, const T& x, const T& y, T& xd, T& yd) {
    const T r2 = x * x + y * y;
    const T up = 1.0 + r2 * (d[0] + r2 * (d[1] + r2 * d[4]));
    const T down = 1.0 + r2 * (d[5] + r2 * (d[6] + r2 * d[7]));
    const T radial = up / down;
    xd = x * radial + 2.0 * d[2] * x * y + d[3] * (r2 + 2.0 * x * x);
    yd = y * radial + d[2] * (r2 + 2.0 * y * y) + 2.0 * d[3] * x * y;
}

/// Inverse of distort by Newton's method with numerically exact derivatives of the scalar kind:
/// `rounds` fixed, so the result is a smooth function that dual numbers can follow.
template <typename T>
void undistort(const T* d, const T& xd, const T& yd, T& x, T& y, int rounds = 8) {
    x = xd;
    y = yd;
    for (int i = 0; i < rounds; ++i) {
        const T r2 = x * x + y * y;
        const T up = 1.0 + r2 * (d[0] + r2 * (d[1] + r2 * d[4]));
        const T down = 1.0 + r2 * (d[5] + r2 * (d[6] + r2 * d[7]));
        const T up1 = d[0] + r2 * (2.0 * d[1] + 3.0 * r2 * d[4]);  // d up / d r2
        const T down1 = d[5] + r2 * (2.0 * d[6] + 3.0 * r2 * d[7]);
        const T radial = up / down;
        const T radial1 = (up1 - radial * down1) / down;  // d radial / d r2
        const T ex = x * radial + 2.0 * d[2] * x * y + d[3] * (r2 + 2.0 * x * x) - xd;
        const T ey = y * radial + d[2] * (r2 + 2.0 * y * y) + 2.0 * d[3] * x * y - yd;
        const T j00 = radial + 2.0 * x * x * radial1 + 2.0 * d[2] * y + 6.0 * d[3] * x;
        const T j01 = 2.0 * x * y * radial1 + 2.0 * d[2] * x + 2.0 * d[3] * y;
        const T j11 = radial + 2.0 * y * y * radial1 + 6.0 * d[2] * y + 2.0 * d[3] * x;
        const T det = j00 * j11 - j01 * j01;
        x = x - (j11 * ex - j01 * ey) / det;
        y = y - (j00 * ey - j01 * ex) / det;
    }
}

}  // namespace stria::camera_math
