#include "tread/io/data_set_writer.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <utility>

#include "tread/io/append_file.hpp"
#include "tread/io/euroc_sensor.hpp"
#include "tread/io/image_file.hpp"
#include "tread/io/raster_file.hpp"
#include "tread/io/recording_folder.hpp"
#include "tread/io/rig_file.hpp"
#include "tread/io/rig_formats.hpp"
#include "tread/io/text.hpp"
#include "tread/io/trajectory_file.hpp"

namespace tread {
namespace {

using internal::AppendFile;
using internal::RecordingFolder;

constexpr const char* kTruth = "state_groundtruth_estimate0";

// The tables and their first lines; those of EuRoC as EuRoC has them.
constexpr const char* kCameraHead = "#timestamp [ns],filename\n";
constexpr const char* kImuHead =
    "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],"
    "a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]\n";
constexpr const char* kTruthHead =
    "#timestamp [ns],p_RS_R_x [m],p_RS_R_y [m],p_RS_R_z [m],q_RS_w [],q_RS_x [],q_RS_y [],"
    "q_RS_z [],v_RS_R_x [m s^-1],v_RS_R_y [m s^-1],v_RS_R_z [m s^-1],b_w_RS_S_x [rad s^-1],"
    "b_w_RS_S_y [rad s^-1],b_w_RS_S_z [rad s^-1],b_a_RS_S_x [m s^-2],b_a_RS_S_y [m s^-2],"
    "b_a_RS_S_z [m s^-2]\n";
constexpr const char* kGnssHead =
    "#timestamp [ns],x [m],y [m],z [m],sigma_level [m],sigma_up [m]\n";
constexpr const char* kWheelsHead =
    "#timestamp [ns],left [rad],right [rad],left_current [A],right_current [A]\n";
constexpr const char* kLegsHead =
    "#timestamp [ns],12 positions [rad],12 velocities [rad s^-1],12 torques [Nm] (left front, "
    "right front, left hind, right hind; HAA HFE KFE),4 foot forces x y z [N]\n";
constexpr const char* kHeadHead = "#timestamp [ns],pan [rad],tilt [rad]\n";
constexpr const char* kBumpHead = "#timestamp [ns],pressed\n";

std::string stem_of(std::int64_t stamp_ns) {
  return fmt::format("{:019d}", stamp_ns);  // fewer than 16 digits would be a number of a frame
}

// "left.tum", "left1.tum", ...
std::string of_head(const std::string& name, int head) {
  return head == 0 ? name : fmt::format("{}{}", name, head);
}

Status check_stamp(std::int64_t stamp_ns, const char* what) {
  if (stamp_ns >= 0) return {};
  return fail(ErrorCode::kBadValue, fmt::format("the stamp {} is before 0", stamp_ns), what,
              "Count time from an epoch before the recording");
}

Status check_setup(const RecordingSetup& setup) {
  const auto bad = [](std::string what, std::string where, std::string remedy) {
    return fail(ErrorCode::kBadArgument, std::move(what), std::move(where), std::move(remedy));
  };
  if (setup.heads.empty()) return bad("there is no head", "heads", "Give at least one stereo rig");
  for (const double rate_hz : {setup.camera_rate_hz, setup.gnss_rate_hz}) {
    if (rate_hz > 0.0 && std::isfinite(rate_hz)) continue;
    return bad(fmt::format("a rate of {} Hz", rate_hz), "recording", "Give a rate above 0");
  }
  if (!setup.p_body_antenna_m.allFinite()) {
    return bad("the place of the antenna is not finite", "p_body_antenna_m", "Give metres");
  }
  for (std::size_t head = 0; head < setup.heads.size(); ++head) {
    const StereoRig& rig = setup.heads[head];
    const std::string where = fmt::format("heads[{}]", head);
    if (!rig.mount) {
      return bad("where it sits on the body is not known", where + ".mount", "Give it a mount");
    }
    if (Status sound = internal::check_whole_rig(rig); !sound) {
      sound.error().where = where + "." + sound.error().where;
      return sound;
    }
  }
  return {};
}

}  // namespace

struct DataSetWriter::State {
  State(const RecordingSetup& recording, std::unique_ptr<RecordingFolder> place)
      : setup(recording), folder(std::move(place)), frames(recording.heads.size()) {}

  [[nodiscard]] Status start();
  [[nodiscard]] Status start_camera(int camera, const CameraModel& model, const StereoRig& rig,
                                    const Isometry3d& T_body_camera);
  [[nodiscard]] Status put(const std::string& name, std::string_view bytes);
  [[nodiscard]] Status append(const std::string& sensor, const char* first_line,
                              std::string_view line);
  [[nodiscard]] Status append_row(const std::string& sensor, const char* first_line,
                                  std::int64_t stamp_ns, std::span<const double> numbers);
  [[nodiscard]] Status put_image(int camera, const std::string& stem,
                                 const Result<std::string>& png);
  [[nodiscard]] Status check_head(int head) const;
  [[nodiscard]] Status may_add() const;
  [[nodiscard]] Status put_poses();
  [[nodiscard]] Status put_description();
  [[nodiscard]] Status finish();
  // Nothing can be made good after this: the recording would have a gap.
  [[nodiscard]] Status broken(Status done) {
    if (!done && done.error().code == ErrorCode::kWriteFailed && !failed) {
      done = tl::unexpected<Error>(folder->renamed(done.error()));
      failed = done.error();
    }
    return done;
  }

  struct Frames {
    std::set<std::int64_t> stamps_ns;
    std::map<std::int64_t, Isometry3d> T_world_left;
  };
  RecordingSetup setup;
  std::unique_ptr<RecordingFolder> folder;
  std::vector<Frames> frames;                // of each head
  std::map<std::string, AppendFile> tables;  // by sensor: "imu0"
  std::map<std::string, std::int64_t> counts;
  std::map<std::int64_t, Isometry3d> T_world_body;
  std::optional<Error> failed;
  bool finished = false;
};

Status DataSetWriter::State::put(const std::string& name, std::string_view bytes) {
  return internal::put_whole_file(folder->staged(name), folder->where(name), bytes);
}

Status DataSetWriter::State::start_camera(int camera, const CameraModel& model,
                                          const StereoRig& rig, const Isometry3d& T_body_camera) {
  const std::string name = fmt::format("cam{}", camera), part = "mav0/" + name;
  const auto text = internal::print_euroc_camera(
      model, rig.size, T_body_camera, setup.camera_rate_hz,
      fmt::format("heads[{}].{}", camera / 2, camera % 2 == 0 ? "left" : "right"));
  if (!text) return forward(text);
  if (Status done = folder->make_folder(part + "/data"); !done) return done;
  if (Status done = put(part + "/sensor.yaml", *text); !done) return done;
  return append(name, kCameraHead, "");
}

Status DataSetWriter::State::start() {
  if (Status done = folder->make_folder("truth"); !done) return done;
  for (std::size_t i = 0; i < setup.heads.size(); ++i) {
    const StereoRig& rig = setup.heads[i];
    const Isometry3d& T_body_left = rig.mount->T_body_left;
    const int camera = 2 * static_cast<int>(i);
    if (Status done = start_camera(camera, rig.left, rig, T_body_left); !done) return done;
    Status done = start_camera(camera + 1, rig.right, rig, T_body_left * rig.T_left_right);
    if (!done) return done;
  }
  StereoRig rig = setup.heads.front();
  if (rig.imu) {
    const Isometry3d T_body_imu = rig.mount->T_body_left * rig.imu->T_imu_left.inverse();
    if (Status done = append("imu0", kImuHead, ""); !done) return done;
    Status done = put("mav0/imu0/sensor.yaml", internal::print_euroc_imu(*rig.imu, T_body_imu));
    if (!done) return done;
  }
  if (setup.head_turns) rig.imu.reset();
  return write_rig(folder->staged("rig.yaml"), rig);
}

// Makes the table with its first line if there is none yet; an empty line only does that.
Status DataSetWriter::State::append(const std::string& sensor, const char* first_line,
                                    std::string_view line) {
  auto table = tables.find(sensor);
  if (table == tables.end()) {
    if (Status done = folder->make_folder("mav0/" + sensor); !done) return done;
    const std::string name = "mav0/" + sensor + "/data.csv";
    auto file = AppendFile::create(folder->staged(name), folder->where(name));
    if (!file) return forward(file);
    table = tables.emplace(sensor, std::move(*file)).first;
    counts[sensor] = 0;
    if (Status done = table->second.append(first_line); !done) return done;
  }
  if (line.empty()) return {};
  ++counts[sensor];
  return table->second.append(line);
}

Status DataSetWriter::State::append_row(const std::string& sensor, const char* first_line,
                                        std::int64_t stamp_ns, std::span<const double> numbers) {
  if (Status may = may_add(); !may) return may;
  if (Status stamp = check_stamp(stamp_ns, sensor.c_str()); !stamp) return stamp;
  if (!std::all_of(numbers.begin(), numbers.end(), [](double v) { return std::isfinite(v); })) {
    return fail(ErrorCode::kBadValue,
                fmt::format("a value of the sample at {} is not finite", stamp_ns), sensor,
                "Leave such samples out");
  }
  return broken(
      append(sensor, first_line, fmt::format("{},{}\n", stamp_ns, fmt::join(numbers, ","))));
}

Status DataSetWriter::State::may_add() const {
  if (failed) return tl::unexpected<Error>(*failed);
  if (!finished) return {};
  return fail(ErrorCode::kBadArgument, "the recording is finished", folder->where(""),
              "Begin another one");
}

Status DataSetWriter::State::check_head(int head) const {
  if (head >= 0 && head < static_cast<int>(setup.heads.size())) return {};
  return fail(ErrorCode::kBadArgument, fmt::format("there is no head {}", head), folder->where(""),
              fmt::format("Heads are 0 to {}", setup.heads.size() - 1));
}

Status DataSetWriter::State::put_image(int camera, const std::string& stem,
                                       const Result<std::string>& png) {
  if (!png) return forward(png);
  const std::string name = fmt::format("cam{}", camera), file = stem + ".png";
  if (Status done = put(fmt::format("mav0/{}/data/{}", name, file), *png); !done) return done;
  return append(name, kCameraHead, fmt::format("{},{}\n", stem, file));
}

// By time, and of frames that came out of order too.
Status DataSetWriter::State::put_poses() {
  const auto write = [&](const std::string& name, const std::map<std::int64_t, Isometry3d>& poses) {
    if (poses.empty()) return Status{};
    Trajectory trajectory;
    for (const auto& [stamp_ns, pose] : poses) trajectory.push_back({stamp_ns, pose});
    return write_tum_trajectory(folder->staged(name), trajectory);
  };
  if (Status done = write("truth/body.tum", T_world_body); !done) return done;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const std::string name = of_head("left", static_cast<int>(i)) + ".tum";
    if (Status done = write("truth/" + name, frames[i].T_world_left); !done) return done;
  }
  return setup.head_turns ? write("poses.txt", frames[0].T_world_left) : Status{};
}

Status DataSetWriter::State::put_description() {
  std::string text = fmt::format("tread_recording: 1\ndescription: {}\nheads: {}\nsamples:\n",
                                 yaml_text(setup.description), setup.heads.size());
  for (const auto& [name, count] : counts) text += fmt::format("  {}: {}\n", name, count);
  return put(internal::kRecordingMark, text);
}

Status DataSetWriter::State::finish() {
  for (auto& [name, table] : tables) {
    if (Status done = table.close(); !done) return done;
  }
  tables.clear();
  if (Status done = put_poses(); !done) return done;
  if (Status done = put_description(); !done) return done;
  return folder->publish();
}

DataSetWriter::DataSetWriter(std::unique_ptr<State> state) : state_(std::move(state)) {}
DataSetWriter::DataSetWriter(DataSetWriter&&) noexcept = default;
DataSetWriter::~DataSetWriter() = default;

Result<DataSetWriter> DataSetWriter::create(const std::filesystem::path& folder,
                                            const RecordingSetup& setup) {
  if (const Status sound = check_setup(setup); !sound) return forward(sound);
  auto place = RecordingFolder::open(folder);
  if (!place) return forward(place);
  auto state = std::make_unique<State>(setup, std::move(*place));
  if (const Status started = state->broken(state->start()); !started) return forward(started);
  return DataSetWriter(std::move(state));
}

Status DataSetWriter::add(int head, const StereoFrame& frame) {
  State& s = *state_;
  if (Status may = s.may_add(); !may) return may;
  if (Status known = s.check_head(head); !known) return known;
  if (Status stamp = check_stamp(frame.stamp_ns, "frame"); !stamp) return stamp;
  const ImageSize size = s.setup.heads[static_cast<std::size_t>(head)].size;
  const bool colour = !frame.left_colour.empty();
  const ImageSize left = colour ? ImageSize{frame.left_colour.width, frame.left_colour.height}
                                : ImageSize{frame.left.width, frame.left.height};
  const ImageSize right{frame.right.width, frame.right.height};
  if (left != size || right != size) {
    return fail(ErrorCode::kBadArgument,
                fmt::format("images of {}x{} and {}x{} pixels, but the rig has {}x{}", left.width,
                            left.height, right.width, right.height, size.width, size.height),
                fmt::format("frame {} of head {}", frame.name, head),
                "Give both images, of the size of the rig");
  }
  State::Frames& seen = s.frames[static_cast<std::size_t>(head)];
  if (!seen.stamps_ns.insert(frame.stamp_ns).second) return {};
  if (frame.T_world_left) seen.T_world_left[frame.stamp_ns] = *frame.T_world_left;
  const std::string stem = stem_of(frame.stamp_ns);
  Status done =
      s.put_image(2 * head, stem,
                  colour ? encode_png(frame.left_colour.view()) : encode_png(frame.left.view()));
  if (done) done = s.put_image(2 * head + 1, stem, encode_png(frame.right.view()));
  return s.broken(std::move(done));
}

Status DataSetWriter::add(const ImuSample& sample) {
  if (!state_->setup.heads.front().imu) {
    return fail(ErrorCode::kBadArgument, "there is no IMU in the rig of head 0", "imu0",
                "Give the rig one");
  }
  const Eigen::Vector3d &w = sample.gyro_rad_per_s, &a = sample.accel_m_per_s2;
  const double numbers[] = {w.x(), w.y(), w.z(), a.x(), a.y(), a.z()};
  return state_->append_row("imu0", kImuHead, sample.stamp_ns, numbers);
}

Status DataSetWriter::add(const GnssFix& fix) {
  const Eigen::Vector3d& p = fix.position_m;
  const double numbers[] = {p.x(), p.y(), p.z(), fix.sigma_level_m, fix.sigma_up_m};
  const bool first = !state_->tables.contains("gnss0");
  Status done = state_->append_row("gnss0", kGnssHead, fix.stamp_ns, numbers);
  if (!done || !first) return done;
  return state_->broken(state_->put(
      "mav0/gnss0/sensor.yaml",
      internal::print_euroc_gnss(state_->setup.p_body_antenna_m, state_->setup.gnss_rate_hz)));
}

Status DataSetWriter::add(const WheelSample& sample) {
  const double numbers[] = {sample.left_rad, sample.right_rad, sample.left_current_a,
                            sample.right_current_a};
  return state_->append_row("wheels0", kWheelsHead, sample.stamp_ns, numbers);
}

Status DataSetWriter::add(const LegSample& sample) {
  std::vector<double> numbers;
  for (const auto* values : {&sample.position_rad, &sample.velocity_rad_per_s, &sample.torque_nm}) {
    numbers.insert(numbers.end(), values->begin(), values->end());
  }
  for (const Eigen::Vector3d& force : sample.foot_force_n) {
    numbers.insert(numbers.end(), force.begin(), force.end());
  }
  return state_->append_row("legs0", kLegsHead, sample.stamp_ns, numbers);
}

Status DataSetWriter::add(const HeadState& state) {
  const double numbers[] = {state.pan_rad, state.tilt_rad};
  return state_->append_row("head0", kHeadHead, state.stamp_ns, numbers);
}

Status DataSetWriter::add(const BumpEvent& event) {
  const double numbers[] = {event.pressed ? 1.0 : 0.0};
  return state_->append_row("bump0", kBumpHead, event.stamp_ns, numbers);
}

Status DataSetWriter::add(const BodyTruth& truth) {
  if (!is_rigid(truth.T_world_body)) {
    return fail(ErrorCode::kBadValue, "T_world_body is not a rigid motion", kTruth,
                "Give an orthonormal rotation and a finite translation");
  }
  const Eigen::Vector3d p = truth.T_world_body.translation();
  const Eigen::Quaterniond q(truth.T_world_body.linear());
  const double sign = q.w() < 0.0 ? -1.0 : 1.0;  // one text for one rotation
  std::vector<double> numbers = {p.x(),        p.y(),        p.z(),       sign * q.w(),
                                 sign * q.x(), sign * q.y(), sign * q.z()};
  for (const Eigen::Vector3d* values :
       {&truth.velocity_m_per_s, &truth.gyro_bias_rad_per_s, &truth.accel_bias_m_per_s2}) {
    numbers.insert(numbers.end(), values->begin(), values->end());
  }
  Status done = state_->append_row(kTruth, kTruthHead, truth.stamp_ns, numbers);
  if (done) state_->T_world_body[truth.stamp_ns] = truth.T_world_body;
  return done;
}

Status DataSetWriter::add_depth(int head, std::int64_t stamp_ns, ImageView<const float> depth) {
  State& s = *state_;
  if (Status may = s.may_add(); !may) return may;
  if (Status known = s.check_head(head); !known) return known;
  if (Status stamp = check_stamp(stamp_ns, "depth"); !stamp) return stamp;
  const std::string part = "truth/" + of_head("depth", head);
  if (Status made = s.broken(s.folder->make_folder(part)); !made) return made;
  const auto path = s.folder->staged(part + "/" + stem_of(stamp_ns) + ".tif");
  return s.broken(write_tiff(path, depth));
}

Status DataSetWriter::add_raster(const std::string& name, const Grid<float>& raster) {
  State& s = *state_;
  if (Status may = s.may_add(); !may) return may;
  if (name.empty() ||
      name.find_first_not_of("abcdefghijklmnopqrstuvwxyz_0123456789") != name.npos) {
    return fail(ErrorCode::kBadArgument, in_quotes(name) + " is no name of a raster",
                s.folder->where("truth"), "Use small letters, digits and '_'");
  }
  return s.broken(write_geotiff(s.folder->staged("truth/" + name + ".tif"), raster));
}

Status DataSetWriter::finish() {
  if (Status may = state_->may_add(); !may) return may;
  Status done = state_->broken(state_->finish());
  state_->finished = done.has_value();
  return done;
}

}  // namespace tread
