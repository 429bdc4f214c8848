#pragma once

#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "core/triangle_mesh.hpp"
#include "viewer/detail/canvas.hpp"
#include "viewer/detail/picture.hpp"

/// What drawings on scans and X-ray frames share.
namespace angio::viewer::detail {

inline constexpr int kDrawingShift = 6;  ///< OpenCV draws to 1/64 pixel

cv::Scalar cv_color(const Rgb& color);
cv::Point fixed_point(double x, double y);
/// @param image  red, green, blue
Picture to_picture(const cv::Mat& image);

/// Small text on a dark edge, so that it reads on any grey.
void draw_text(cv::Mat& picture, const std::string& text, cv::Point at, double size);

/// The outline of a surface's shadow: every triangle filled, then the border of the whole.
/// @param places  where the picture sees the vertices
void draw_shadow_outline(cv::Mat& picture, const TriangleMesh& mesh,
                         const std::vector<Spot>& places, const Rgb& color);

}  // namespace angio::viewer::detail
