// Drawing on colour pictures with smooth edges: lines, discs, rings, plates and text. Coordinates
// are pixels, x right, y down, (0, 0) is the centre of the top left pixel; whatever lies outside
// the picture is cut off.
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>

#include "tread/core/image.hpp"

namespace tread {

// Mixes `colour` over the pixel, which may lie outside; opacity 0 to 1.
void blend(ImageView<Rgb> picture, int x, int y, Rgb colour, double opacity);

// A line of the width with round ends and corners. A single point gives a disc.
void draw_polyline(ImageView<Rgb> picture, std::span<const Eigen::Vector2d> points, double width_px,
                   Rgb colour);
void draw_disc(ImageView<Rgb> picture, const Eigen::Vector2d& centre, double radius_px, Rgb colour);
void draw_ring(ImageView<Rgb> picture, const Eigen::Vector2d& centre, double radius_px,
               double width_px, Rgb colour);
// Columns x to x + width - 1 and rows y to y + height - 1.
void fill_rectangle(ImageView<Rgb> picture, int x, int y, int width, int height, Rgb colour,
                    double opacity = 1.0);

struct TextSize {
  int width = 0;
  int height = 0;  // of the capital letters
};
// ASCII text of letters `height_px` high.
[[nodiscard]] TextSize text_size(const std::string& text, int height_px);
// Its lower left corner is at (x, y).
void draw_text(ImageView<Rgb> picture, int x, int y, const std::string& text, int height_px,
               Rgb colour);

}  // namespace tread
