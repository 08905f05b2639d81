// metrics.csv: a bake in numbers, from positions and velocities, in double precision.
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <functional>
#include <optional>
#include <sstream>

#include "host/bake/look.h"
#include "host/bake/outputs.h"
#include "host/bake/points.h"
#include "host/base/csv.h"
#include "host/base/parallel.h"
#include "host/base/part_file.h"
#include "host/base/text.h"
#include "host/formats/formats.h"
#include "host/model/overlap.h"
#include "host/model/surroundings.h"

namespace fascicle::bake {

namespace {

double squared_length(const Point& a) {
  return dot(a, a);
}

// For the tetrahedron whose corners begin at entry `t`, cubic working units; negative if it is inside out.
double six_volumes(const model::Model& model, const std::vector<float>& positions, std::size_t t) {
  const Point corner = point_at(positions, model.tetrahedron[t]);
  const auto edge = [&](std::size_t k) {
    return difference(point_at(positions, model.tetrahedron[t + k]), corner);
  };
  return determinant(edge(1), edge(2), edge(3));
}

// For each tetrahedron.
void six_volumes(const model::Model& model, const std::vector<float>& positions, std::vector<double>& to) {
  to.resize(model.tetrahedron.size() / 4);
  for (std::size_t t = 0; t < to.size(); ++t) to[t] = six_volumes(model, positions, 4 * t);
}

double cubic_metres(const model::Model& model) {
  return model.unit * model.unit * model.unit;
}

// Per tetrahedron: whether it is of the body, and carries no floor, whose carrier may be far larger.
std::vector<char> tetrahedra_of_body(const model::Model& model, const std::vector<char>& is_beside) {
  std::vector<char> is_body;
  for (std::size_t t = 0; t < model.tetrahedron.size(); t += 4)
    is_body.push_back(is_beside[model.tetrahedron[t]] == 0 ? 1 : 0);
  return is_body;
}

// m^3
double volume(const model::Model& model, const std::vector<double>& six, const std::vector<char>& is_body) {
  double sum = 0.0;
  for (std::size_t t = 0; t < six.size(); ++t)
    if (is_body[t] != 0) sum += six[t];
  return sum / 6.0 * cubic_metres(model);
}

// m^3 per layer: a quarter of each tetrahedron for each of its vertices in the layer.
std::vector<double> layer_volumes(const model::Model& model, const std::vector<double>& six,
                                  const std::vector<char>& is_body) {
  std::vector<double> sum(model.layers.size(), 0.0);
  for (std::size_t t = 0; t < six.size(); ++t)
    for (std::size_t k = 0; k < 4 && is_body[t] != 0; ++k)
      sum[model.layer_of(model.tetrahedron[4 * t + k])] += six[t];
  for (double& volume : sum) volume = volume / 24.0 * cubic_metres(model);
  return sum;
}

// J
double kinetic_energy(const model::Model& model, const std::vector<float>& velocities,
                      const std::vector<char>& is_beside) {
  double sum = 0.0;
  for (std::size_t i = 0; i < model.vertex_count; ++i)
    if (is_beside[i] == 0) sum += model.mass[i] * squared_length(point_at(velocities, i));
  return 0.5 * sum * (model.unit * model.unit);
}

// Tetrahedra that are flat or turned inside out.
std::uint64_t inverted(const std::vector<double>& six) {
  return static_cast<std::uint64_t>(
      std::count_if(six.begin(), six.end(), [](double one) { return !(one > 0.0); }));
}

// m per layer: root mean square distance of its free vertices from their skinned positions.
std::vector<double> lags(const model::Model& model, const model::Frame& frame) {
  std::vector<double> sum(model.layers.size(), 0.0), count(model.layers.size(), 0.0);
  for (std::uint32_t i = 0; i < model.vertex_count; ++i) {
    if (model.is_kinematic(i)) continue;
    sum[model.layer_of(i)] +=
        squared_length(difference(point_at(frame.positions, i), point_at(frame.skinned, i)));
    count[model.layer_of(i)] += 1.0;
  }
  for (std::size_t l = 0; l < sum.size(); ++l)
    sum[l] = count[l] > 0.0 ? std::sqrt(sum[l] / count[l]) * model.unit : 0.0;
  return sum;
}

// m, in the world: the two frames may have different origins.
double largest_displacement(const model::Model& model, const model::Frame& frame,
                            const model::Frame& initial) {
  const Point shift = difference(frame.origin, initial.origin);
  double largest = 0.0;
  for (std::size_t i = 0; i < model.vertex_count; ++i) {
    const Point moved = difference(point_at(frame.positions, i), point_at(initial.positions, i));
    Point metres;
    for (std::size_t axis = 0; axis < 3; ++axis) metres[axis] = shift[axis] + model.unit * moved[axis];
    largest = std::max(largest, squared_length(metres));
  }
  return std::sqrt(largest);
}

// m, in the world
Point mean_position(const model::Model& model, const model::Frame& frame, const model::ProbeSet& probe) {
  Point sum{0, 0, 0};
  for (const std::uint32_t i : probe.vertices) {
    const Point p = point_at(frame.positions, i);
    for (std::size_t axis = 0; axis < 3; ++axis) sum[axis] += p[axis];
  }
  Point mean;
  for (std::size_t axis = 0; axis < 3; ++axis)
    mean[axis] = frame.origin[axis] + model.unit * (sum[axis] / static_cast<double>(probe.vertices.size()));
  return mean;
}

class MetricsSink final : public formats::FrameSink {
 public:
  explicit MetricsSink(const LookBody* body) : look_body_(body) {}
  std::string name() const override { return "metrics"; }
  model::Read needs() const override { return {.positions = true, .velocities = true, .skinned = true}; }
  void begin(const formats::BakeInfo& info) override {
    info_ = info;
    if (has_look(*info.model)) {
      if (look_body_ == nullptr) look_body_ = &own_look_body_.emplace(look_body(*info.model, info.rig));
      look_.emplace(*info.model, *look_body_, info.fps);
      for (const model::Frame& frame : info.before) look_->remember(frame);
    }
    if (info.model->has_contact()) overlap_.emplace(*info.model);
    six_volumes(*info.model, info.model->rest, six_volumes_);
    is_beside_ = model::surroundings_of(*info.model).vertices;
    is_body_ = tetrahedra_of_body(*info.model, is_beside_);
    rest_volume_ = volume(*info.model, six_volumes_, is_body_);
    rest_layer_volumes_ = layer_volumes(*info.model, six_volumes_, is_body_);
    const std::filesystem::path path = info.folder / metrics_name;
    const std::string header = header_line();
    if (info.first == 0) {
      file_.emplace(base::PartFile::start(path));
      file_->write(header);
    } else {
      file_.emplace(base::PartFile::resume_lines(path, 1 + info.first));
    }
  }
  void write(const model::Frame& frame) override {
    const bool has_skin = info_.model->has_skeleton();
    Line motion, volumes, overlap, overlap_skinned, look;
    // Pieces that take about equally long: with a GPU, a bake waits for these measurements.
    std::vector<std::function<void()>> pieces{[&] { add_motion(frame, motion, volumes); }};
    if (look_) pieces.emplace_back([&] { add_look(frame, look); });
    if (overlap_) pieces.emplace_back([&] { add_overlap(frame.positions, overlap); });
    if (overlap_ && has_skin) pieces.emplace_back([&] { add_overlap(frame.skinned, overlap_skinned); });
    base::for_each_in_parallel(pieces.size(), base::thread_count(),
                               [&](std::size_t piece, std::size_t) { pieces[piece](); });
    file_->write(base::number_text(frame.index) + motion.text + overlap.text + overlap_skinned.text +
                 volumes.text + look.text + '\n');
  }
  void sync() override { file_->sync(); }
  void finish() override { file_->finish(); }

 private:
  // Cells of a row, each after a comma.
  struct Line {
    std::string text;
    template <class Number>
    void add(Number value) {
      text += ',' + base::number_text(value);
    }
  };

  void add_motion(const model::Frame& frame, Line& motion, Line& volumes) {
    const model::Model& model = *info_.model;
    six_volumes(model, frame.positions, six_volumes_);
    const double now = volume(model, six_volumes_, is_body_);
    motion.add(info_.start + static_cast<double>(frame.index) / info_.fps);
    motion.add(kinetic_energy(model, frame.velocities, is_beside_));
    motion.add(now);
    motion.add(now / rest_volume_);
    motion.add(largest_displacement(model, frame, *info_.initial));
    motion.add(inverted(six_volumes_));
    const std::vector<double> of_layers = layer_volumes(model, six_volumes_, is_body_);
    for (std::size_t l = 0; l < of_layers.size(); ++l) {
      volumes.add(of_layers[l]);
      volumes.add(rest_layer_volumes_[l] > 0.0 ? of_layers[l] / rest_layer_volumes_[l] : 1.0);
    }
    for (const model::ProbeSet& probe : model.probes)
      for (const double coordinate : mean_position(model, frame, probe)) volumes.add(coordinate);
    if (!model.has_skeleton()) return;
    six_volumes(model, frame.skinned, six_volumes_);
    motion.add(inverted(six_volumes_));
    for (const double lag : lags(model, frame)) motion.add(lag);
  }

  void add_overlap(const std::vector<float>& positions, Line& line) const {
    const model::Overlap overlap = overlap_->of(positions);
    line.add(overlap.vertices);
    line.add(overlap.deepest);
    line.add(overlap.volume);
  }

  void add_look(const model::Frame& frame, Line& line) {
    const LookScores scores = look_->of(frame);
    const LookScore& worst = scores.worst();
    line.add(worst.score);
    line.text += ',' + (worst.score > 0.0 ? base::csv_field(look_body_->joint_names[worst.joint]) : "");
    for (const LookScore& score : scores.of) line.add(score.score);
  }

  std::string header_line() const {
    std::string line = "frame,time,kinetic_energy,volume,volume_ratio,largest_displacement,inverted";
    if (info_.model->has_skeleton()) {
      line += ",inverted_skinned";
      for (const model::Layer& layer : info_.model->layers)
        line += ',' + base::csv_field(lag_column + layer.name);
    }
    if (overlap_) {
      line += ",contact_vertices,contact_deepest,contact_volume";
      if (info_.model->has_skeleton())
        line +=
            std::string(",contact_vertices_skinned,") + deepest_skinned_column + ",contact_volume_skinned";
    }
    for (const model::Layer& layer : info_.model->layers)
      for (const char* column : {volume_column, volume_ratio_column})
        line += ',' + base::csv_field(column + layer.name);
    for (const model::ProbeSet& probe : info_.model->probes)
      for (const char* axis : {"_x", "_y", "_z"}) line += ',' + base::csv_field(probe.name + axis);
    if (look_) {
      line += std::string(",") + look_column + ',' + look_joint_column;
      for (std::size_t m = 0; m < look_measures; ++m)
        line += std::string(",") + look_column + '_' + name_of(static_cast<LookMeasure>(m));
    }
    return line + '\n';
  }

  formats::BakeInfo info_;

  double rest_volume_ = 0.0;                // m^3
  std::vector<double> rest_layer_volumes_;  // m^3
  std::vector<char> is_beside_;             // per vertex: carries surroundings
  std::vector<char> is_body_;               // per tetrahedron
  std::vector<double> six_volumes_;         // of the current frame
  std::optional<LookBody> own_look_body_;   // if the caller has none
  const LookBody* look_body_ = nullptr;
  std::optional<Look> look_;                    // only with a skeleton and a render mesh
  std::optional<model::OverlapMeter> overlap_;  // only for a model with contact
  std::optional<base::PartFile> file_;
};

}  // namespace

std::unique_ptr<formats::FrameSink> make_metrics_sink(const LookBody* body) {
  return std::make_unique<MetricsSink>(body);
}

std::vector<PeakLag> peak_lags(const std::filesystem::path& folder, const model::Model& model) {
  std::vector<PeakLag> peaks;
  if (!model.has_skeleton()) return peaks;
  std::istringstream file(
      base::read_input_if_there(folder / metrics_name, base::most_metrics_bytes).value_or(""));
  const auto cells = [&file] {
    std::string line;
    return std::getline(file, line) ? base::csv_fields(line) : std::vector<std::string>();
  };
  const std::vector<std::string> header = cells();
  std::vector<std::size_t> columns;
  for (std::uint32_t l = 0; l < model.layers.size(); ++l) {
    const std::string column = base::csv_fields(base::csv_field(lag_column + model.layers[l].name)).front();
    const auto at = std::find(header.begin(), header.end(), column);
    if (at == header.end()) return {};
    columns.push_back(static_cast<std::size_t>(at - header.begin()));
    peaks.push_back({model.layers[l].name, 0.0, 0});
  }
  for (std::vector<std::string> row = cells(); !row.empty(); row = cells())
    for (std::size_t l = 0; l < peaks.size() && columns[l] < row.size(); ++l) {
      const std::string& text = row[columns[l]];
      double lag = 0.0;
      std::from_chars(text.data(), text.data() + text.size(), lag);
      if (lag <= peaks[l].lag) continue;
      peaks[l].lag = lag;
      std::from_chars(row[0].data(), row[0].data() + row[0].size(), peaks[l].frame);
    }
  std::erase_if(peaks, [](const PeakLag& peak) { return peak.lag == 0.0; });
  return peaks;
}

std::uint64_t metrics_bytes(const model::Model& model, std::uint64_t frames) {
  // A number takes up to 24 characters and a comma, usually about 19.
  return (frames + 1) *
         (std::uint64_t{7} + (has_look(model) ? 2 + look_measures : 0) + (model.has_contact() ? 6 : 0) +
          2 * model.layers.size() + (model.has_skeleton() ? 1 + model.layers.size() : 0) +
          3 * model.probes.size()) *
         20;
}

}  // namespace fascicle::bake
