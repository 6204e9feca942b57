#include "tread/slam/align.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include "tread/core/parallel.hpp"

namespace tread {
namespace {

void set_motion(const Isometry3d& T, float* R, float* t) {
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) R[3 * i + j] = static_cast<float>(T.linear()(i, j));
    t[i] = static_cast<float>(T.translation()[i]);
  }
}

// Sums over chunks in their order, whatever thread worked on them.
template <class Sums, class Body>
Sums sum_chunks(const Context& context, int count, int grain, const Body& body) {
  const int chunks = (count + grain - 1) / grain;
  std::vector<Sums> parts(static_cast<std::size_t>(chunks));
  parallel_chunks(context, 0, count, grain, [&](int first, int last) {
    body(first, last, parts[static_cast<std::size_t>(first / grain)]);
  });
  Sums sum;
  for (const Sums& part : parts) sum += part;
  return sum;
}

class Aligner {
 public:
  Aligner(const AlignFrame& frame, const std::array<DepthLevel, 3>* model,
          const Isometry3d& T_world_model, const PhotoKeyframe* key, const PosePrior& prior,
          const DepthNoise& noise, const AlignOptions& options, const Context& context)
      : frame_(frame),
        model_(model),
        T_world_model_(T_world_model),
        key_(options.intensity && frame.has_grey() ? key : nullptr),
        prior_(prior),
        noise_(noise),
        options_(options),
        context_(context),
        T_(T_world_model.inverse() * prior.T_world_camera) {}

  Alignment run() {
    const std::array iterations{options_.fine_iterations, options_.middle_iterations,
                                options_.coarse_iterations};
    const double mean = mean_depth(frame_.depth[1].depth);
    mean_depth_m_ = mean > 0.0 ? mean : 1.0;
    inverse_scale_ << 1.0, 1.0, 1.0, Eigen::Vector3d::Constant(mean_depth_m_);
    scale_ = inverse_scale_.cwiseInverse();
    for (int level = 2; level >= 0; --level) {
      found_.converged = false;
      grey_sigma_ = std::max(options_.least_grey_sigma, grey_sigma_);
      for (int i = 0; i < iterations[static_cast<std::size_t>(level)]; ++i) {
        const Vector6d step = iterate(static_cast<std::size_t>(level), i == 0);
        if (!step.allFinite()) break;
        T_ = se3_exp(step) * T_;
        if (step.cwiseAbs().maxCoeff() < options_.least_step) {
          found_.converged = true;
          break;
        }
      }
    }
    finish();
    return found_;
  }

 private:
  [[nodiscard]] NormalEquations depth_equations(std::size_t level, bool with_cross) const {
    if (model_ == nullptr) return {};
    IcpJob job;
    job.frame = DepthView::of(frame_.depth[level]);
    job.model = DepthView::of((*model_)[level]);
    set_motion(T_, job.R, job.t);
    job.gate_m = static_cast<float>(options_.gate_m);
    job.least_cosine =
        static_cast<float>(std::cos(options_.gate_angle_deg * std::numbers::pi / 180.0));
    job.constant_m = static_cast<float>(noise_.constant_m);
    job.quadratic_per_m = static_cast<float>(noise_.quadratic_per_m);
    return sum_chunks<NormalEquations>(context_, job.frame.depth.height, 16,
                                       [&](int first, int last, NormalEquations& sums) {
                                         icp_rows(job, first, last, with_cross, sums);
                                       });
  }

  [[nodiscard]] PhotoSums photo_sums(std::size_t level, bool with_cross) const {
    PhotoJob job;
    job.points = PhotoPointsView::of(key_->points[level]);
    const GreyLevel& grey = frame_.grey[level];
    job.image = grey.intensity;
    job.image_gx = grey.gx;
    job.image_gy = grey.gy;
    job.camera = key_->camera[level];
    set_motion((T_world_model_ * T_).inverse() * key_->T_world_camera, job.R, job.t);
    job.gain = static_cast<float>(found_.gain);
    job.offset = static_cast<float>(found_.offset);
    job.sigma = static_cast<float>(grey_sigma_);
    return sum_chunks<PhotoSums>(context_, job.points.size, 4096,
                                 [&](int first, int last, PhotoSums& sums) {
                                   photo_points(job, first, last, with_cross, sums);
                                 });
  }

  // Gain and offset that fit best, and the spread of what is left, for the next iteration.
  void fit_exposure(const PhotoSums& sums) {
    const NormalEquations& e = sums.equations;
    if (e.count < 50) return;
    const double n = e.weight;
    const double variance = sums.here_here / n - (sums.here / n) * (sums.here / n);
    const double covariance = sums.key_here / n - (sums.here / n) * (sums.key / n);
    if (variance > 1.0) found_.gain = std::clamp(covariance / variance, 0.5, 2.0);
    found_.offset = sums.key / n - found_.gain * sums.here / n;
    grey_sigma_ =
        std::max(options_.least_grey_sigma, 1.2533 * sums.absolute / static_cast<double>(e.count));
  }

  // One Gauss-Newton step: a left twist in axes of the model's camera.
  Vector6d iterate(std::size_t level, bool with_cross) {
    depth_ = depth_equations(level, with_cross);
    // In directions that depth does not tell, what it has is the noise of normals, which would hold
    // the camera where it is.
    if (with_cross) {
      const auto unknown =
          find_observability(depth_.cross, mean_depth_m_, options_.observability).unknown;
      const Matrix6d keep = Matrix6d::Identity() - unknown * unknown.transpose();
      keep_ = inverse_scale_.asDiagonal() * keep * scale_.asDiagonal();
    }
    H_ = keep_ * depth_.H * keep_.transpose();
    Vector6d g = keep_ * depth_.g;
    Matrix6d cross = keep_ * depth_.cross * keep_.transpose();
    if (key_ != nullptr && key_->points[level].size() > 0) {
      const PhotoSums photo = photo_sums(level, with_cross);
      // A twist d of the keyframe's points is the twist -Ad d of the frame.
      const Matrix6d to_key = -se3_adjoint(key_->T_world_camera.inverse() * T_world_model_);
      photo_ = photo.equations;
      found_.photo_points = key_->points[level].size();
      photo_.H = to_key.transpose() * photo.equations.H * to_key;
      photo_.g = to_key.transpose() * photo.equations.g;
      photo_.cross = to_key.transpose() * photo.equations.cross * to_key;
      const double share = options_.intensity_share;
      if (level == 0 && !with_cross) compare(g);
      H_ += share * photo_.H;
      g += share * photo_.g;
      cross += share * photo_.cross;
      fit_exposure(photo);
    }
    if (with_cross) {
      found_.observability = find_observability(cross, mean_depth_m_, options_.observability);
    }
    return solve(g);
  }

  // How far apart the motions are that depth and intensity would have, each by itself, beside how
  // far they may be: the mean square of six numbers that should have deviation one.
  void compare(const Vector6d& depth_g) {
    const double c = options_.observability.correlation;
    const auto scale = scale_.asDiagonal();
    const Matrix6d weak = Matrix6d::Identity();  // a metre
    const Matrix6d depth = (scale * H_ * scale / c + weak).inverse();
    const Matrix6d photo = (scale * photo_.H * scale / c + weak).inverse();
    const Vector6d apart = depth * (scale * depth_g) / c - photo * (scale * photo_.g) / c;
    found_.disagreement = apart.dot((depth + photo).ldlt().solve(apart)) / 6.0;
  }

  // Directions that the frame does not tell are left to the prior alone.
  Vector6d solve(const Vector6d& g) {
    const auto scale = scale_.asDiagonal();
    Matrix6d H = scale * H_ * scale;
    Vector6d b = scale * g;
    const auto& unknown = found_.observability.unknown;
    const Matrix6d keep = Matrix6d::Identity() - unknown * unknown.transpose();
    H = keep * H * keep / options_.observability.correlation;
    b = keep * b / options_.observability.correlation;
    // The prior, in axes of the model's camera: r = log(T T_prior^-1).
    const Isometry3d T_prior = T_world_model_.inverse() * prior_.T_world_camera;
    const Vector6d r = se3_log(T_ * T_prior.inverse());
    const Matrix6d to_camera = se3_adjoint(T_prior.inverse());
    const Matrix6d information =
        scale * to_camera.transpose() * prior_.information * to_camera * scale;
    H += information;
    b += information * (inverse_scale_.asDiagonal() * r);
    H.diagonal().array() += 1e-9 * std::max(1.0, H.diagonal().maxCoeff());
    total_ = H;
    return -(scale * H.ldlt().solve(b));
  }

  void finish() {
    found_.T_world_camera = T_world_model_ * T_;
    // Left to itself, the error of a rotation that is no rotation would treble with every frame:
    // R R^T R of the model's and the frame's.
    found_.T_world_camera.linear() =
        Eigen::Quaterniond(found_.T_world_camera.linear()).normalized().toRotationMatrix();
    found_.matched = depth_.count;
    found_.depth_rms =
        depth_.weight > 0.0 ? std::sqrt(depth_.error / static_cast<double>(depth_.count)) : 0.0;
    const DepthLevel& fine = frame_.depth[0];
    for (int y = 0; y < fine.height(); ++y) {
      const float* n = fine.normal[0].row(y);
      found_.measured += std::count_if(n, n + fine.width(), [](float v) { return v == v; });
    }
    if (key_ != nullptr) {
      found_.photo_matched = photo_.count;
      found_.grey_rms = grey_sigma_;
    }
    // From axes of the model's camera to those of the frame's.
    const Matrix6d inverse = total_.ldlt().solve(Matrix6d::Identity());
    const Matrix6d covariance = scale_.asDiagonal() * inverse * scale_.asDiagonal();
    const Matrix6d to_camera = se3_adjoint(T_.inverse());
    found_.covariance = to_camera * covariance * to_camera.transpose();
  }

  const AlignFrame& frame_;
  const std::array<DepthLevel, 3>* model_;
  const Isometry3d& T_world_model_;
  const PhotoKeyframe* key_;
  const PosePrior& prior_;
  const DepthNoise& noise_;
  const AlignOptions& options_;
  const Context& context_;
  Isometry3d T_;  // model camera from frame
  // Turns count as the way they make at the mean depth.
  Vector6d scale_ = Vector6d::Ones(), inverse_scale_ = Vector6d::Ones();
  Matrix6d keep_ = Matrix6d::Identity();
  Matrix6d H_ = Matrix6d::Zero();
  Matrix6d total_ = Matrix6d::Identity();
  NormalEquations depth_, photo_;
  double mean_depth_m_ = 1.0;
  double grey_sigma_ = 10.0;
  Alignment found_;
};

}  // namespace

OptionSet describe(AlignOptions& options) {
  OptionSet set;
  set.add("fine_iterations", options.fine_iterations, "at most, at the finest level", 1, 100);
  set.add("middle_iterations", options.middle_iterations, "at the middle one", 0, 100);
  set.add("coarse_iterations", options.coarse_iterations, "at the coarsest one", 0, 100);
  set.add("gate_m", options.gate_m, "points farther apart are not the same, m", 0.001, 10.0);
  set.add("gate_angle_deg", options.gate_angle_deg, "nor with normals farther apart, degrees", 1.0,
          90.0);
  set.add("least_step", options.least_step, "m and rad: a smaller step ends a level", 0.0, 0.1);
  set.add("intensity", options.intensity, "align images as well as depth");
  set.add("intensity_share", options.intensity_share,
          "weight of intensities beside depths: they err alike over larger patches", 0.0, 100.0);
  set.add("least_grey_sigma", options.least_grey_sigma, "of an intensity, grey values", 0.1, 100.0);
  set.add_group("observability", describe(options.observability));
  return set;
}

Alignment align(const AlignFrame& frame, const std::array<DepthLevel, 3>* model,
                const Isometry3d& T_world_model, const PhotoKeyframe* key, const PosePrior& prior,
                const DepthNoise& noise, const AlignOptions& options, const Context& context) {
  const ScopedTimer timer(context, "slam/align");
  return Aligner(frame, model, T_world_model, key, prior, noise, options, context).run();
}

namespace {

// One level of align_rotation.
Eigen::Matrix3d turn_at(const GreyLevel& first, const GreyLevel& second, const Pinhole& camera,
                        const Eigen::Matrix3d& start) {
  // Every pixel a point at depth one; of its motion only the turn is looked for.
  PhotoPoints points;
  const int width = first.intensity.width, height = first.intensity.height;
  for (int y = 1; y + 1 < height; ++y) {
    for (int x = 1; x + 1 < width; ++x) {
      points.x.push_back((static_cast<float>(x) - camera.cx) / camera.fx);
      points.y.push_back((static_cast<float>(y) - camera.cy) / camera.fy);
      points.z.push_back(1.0F);
      points.intensity.push_back(first.intensity.row(y)[x]);
      points.gx.push_back(first.gx.row(y)[x]);
      points.gy.push_back(first.gy.row(y)[x]);
    }
  }
  PhotoJob job;
  job.points = PhotoPointsView::of(points);
  job.image = second.intensity;
  job.image_gx = second.gx;
  job.image_gy = second.gy;
  job.camera = camera;
  job.sigma = 10.0F;
  struct Look {
    Eigen::Matrix3d R_second_first;
    PhotoSums sums;
    double error;
  };
  const auto look = [&](const Eigen::Matrix3d& R) {
    Isometry3d T = Isometry3d::Identity();
    T.linear() = R;
    set_motion(T, job.R, job.t);
    Look at{R, {}, std::numeric_limits<double>::infinity()};
    photo_points(job, 0, points.size(), false, at.sums);
    // Pixels that left the image do not make a turn better.
    const std::int64_t count = at.sums.equations.count;
    if (2 * count > points.size()) at.error = at.sums.absolute / static_cast<double>(count);
    return at;
  };
  Look best = look(start.transpose());
  if (const Look still = look(Eigen::Matrix3d::Identity()); !(best.error <= still.error)) {
    best = still;
  }
  for (int i = 0; i < 12; ++i) {
    Eigen::Matrix3d H = best.sums.equations.H.bottomRightCorner<3, 3>();
    H.diagonal().array() += 1e-6 * H.diagonal().maxCoeff() + 1e-12;
    const Eigen::Vector3d step = -H.ldlt().solve(best.sums.equations.g.tail<3>());
    if (!step.allFinite()) break;
    const Look next = look(best.R_second_first * so3_exp(step));
    if (!(next.error < best.error)) break;
    best = next;
    if (step.norm() < 1e-4) break;
  }
  return best.R_second_first.transpose();
}

}  // namespace

Eigen::Matrix3d align_rotation(const GreyLevel& first, const GreyLevel& second,
                               const Pinhole& camera, const Eigen::Matrix3d& start) {
  const GreyLevel small_first = halved(first), small_second = halved(second);
  const Eigen::Matrix3d coarse = turn_at(small_first, small_second, camera.halved(), start);
  return turn_at(first, second, camera, coarse);
}

}  // namespace tread
