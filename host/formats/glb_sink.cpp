// surface.glb: glTF 2.0. The character with its skeleton and looks, its flesh as sparse morph targets on top
// of skinning, and one animation that drives both.
//
// A target stores the difference between the baked and the skinned position of each vertex, multiplied by the
// inverse of the vertex's blended joint transform. Viewers add morph targets before skinning. At a target's
// frame they therefore show the baked surface; between frames the skeleton rotates properly, and only this
// small remainder is interpolated linearly. Vertices that plain skinning puts in the right place are not
// stored: targets are sparse. For a body without a skeleton, the targets hold the whole motion. Normals are
// the file's own, rotated with the surface (SurfaceNormals), which keeps creases. They are not stored where
// plain skinning gives the same normal. Viewers rotate normals by a vertex's blended joint transform itself,
// not by its inverse transpose: below a joint that is scaled unevenly, they would be wrong without a target.
//
// The targets' numbers go into a temporary stream, because the JSON that precedes them in the file is only
// known at the end. They are sparse (glb_sparse.h) or compressed (glb_compress.h).
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <Eigen/Eigenvalues>

#include "host/base/errors.h"
#include "host/base/part_file.h"
#include "host/base/text.h"
#include "host/formats/character_file.h"
#include "host/formats/formats.h"
#include "host/formats/glb_compress.h"
#include "host/formats/glb_document.h"
#include "host/formats/glb_sparse.h"
#include "host/formats/glb_targets.h"
#include "host/formats/gltf_writer.h"
#include "host/formats/surface.h"
#include "host/formats/surface_normals.h"
#include "host/formats/surface_objects.h"
#include "host/formats/uneven_joints.h"
#include "host/gltf/gltf_check.h"
#include "host/gltf/gltf_file.h"
#include "host/rig/pose.h"
#include "host/rig/rig_math.h"

namespace fascicle::formats {

namespace {

using Eigen::Matrix3d;
using Eigen::Matrix4d;
using Eigen::Vector3d;
using nlohmann::json;

constexpr const char* glb_spool = "surface.glb.targets";
// Normals that turn by less (radians) are not stored.
constexpr double least_turn = 0.004;
constexpr double default_tolerance = 1e-6;  // as a fraction of the body's diagonal
constexpr std::size_t most_targets = 65535;
constexpr std::size_t most_targets_of_all = std::size_t{1} << 22u;
// Browser viewers store targets as the layers of an array texture, and WebGL 2 guarantees no more.
constexpr std::size_t most_in_browsers = 256;

// A character's clip may give its joints any size. No sensible one comes near.
constexpr double most_of_joint = 1e15;

// Whether a file should hold the move. A joint of almost no size hides its vertices, and would need huge
// ones.
bool is_stored(const Vector3d& move) {
  constexpr double most = 1e18;
  return move.cwiseAbs().maxCoeff<Eigen::PropagateNaN>() <= most;
}

class GlbSink final : public FrameSink {
 public:
  std::string name() const override { return "glb"; }
  model::Read needs() const override { return {.surface = true}; }
  bool resumes() const override { return false; }
  void begin(const BakeInfo& info) override;
  void write(const model::Frame& frame) override;
  // No checkpoint relies on this file: a resumed bake rewrites it.
  void sync() override {}
  void finish() override;
  SinkReport report() const override;

 private:
  void read_character(const BakeInfo& info);
  void require_listable(std::uint64_t targets) const;
  Matrix4d slot_at(const gltf::RigPart& part, std::size_t slot, const std::vector<Matrix4d>& joints,
                   std::uint64_t frame) const;
  std::vector<double> stretch() const;
  GlbFrame frame_of(const model::Frame& frame) const;
  void write_target(const GlbFrame& frame);
  void add_targets(json& document, const std::vector<std::size_t>& meshes);

  BakeInfo info_;
  double tolerance_ = 0.0;
  std::size_t primitives_ = 0;  // of meshes that get targets
  gltf::GltfDocument document_;
  gltf::Rig rig_;
  std::optional<SurfaceNormals> normals_;
  std::optional<GlbTargetChoice> choice_;
  GlbSparseTargets sparse_{rig_};
  std::optional<GlbCompression> compression_;  // of the targets; none: they are sparse
  std::vector<std::uint64_t> targets_;         // their frame numbers
  std::optional<base::SpoolFile> stream_;
  std::uint64_t stream_bytes_ = 0;
};

void GlbSink::read_character(const BakeInfo& info) {
  const model::Model& model = *info.model;
  if (info.character.empty()) {
    document_ = plain_document(model);
    gltf::RigPart& part = rig_.parts.emplace_back();
    const std::vector<float> rest = embed(model, model.rest);
    const std::vector<float> points = world_positions(rest, model.unit, model.rest_origin);
    const std::vector<float> normals = SurfaceNormals(model).of(rest);
    for (std::size_t i = 0; i < model.surface_count(); ++i) {
      part.positions.push_back(vector_at(points, i));
      part.normals.push_back(vector_at(normals, i));
    }
    return;
  }
  gltf::GltfFile file = gltf::read_gltf_file(info.character);
  const bool has_binary = file.has_binary;
  document_.binary.assign(file.binary.begin(), file.binary.end());
  document_.json = gltf::check_gltf(std::move(file)).plain;
  rig_ = read_kept_rig(info.character, model);
  // The buffer becomes the start of surface.glb's buffer.
  const json& buffers = document_.json["buffers"];
  if (!has_binary || buffers.size() != 1 || buffers[0].contains("uri"))
    throw base::BakeError(info.character.string() +
                          ": its bytes are not all in one buffer of the file; bake again with --overwrite");
}

// The JSON lists each target of each primitive.
void GlbSink::require_listable(std::uint64_t targets) const {
  if (targets <= most_targets_of_all / std::max<std::size_t>(primitives_, 1)) return;
  throw base::BakeError("glb: the character's meshes have " + base::number_text(std::uint64_t{primitives_}) +
                        " primitives, too many for " + base::number_text(targets) +
                        " morph targets each; join meshes, or give a larger --glb-stride or --glb-error");
}

void GlbSink::begin(const BakeInfo& info) {
  info_ = info;
  const model::Model& model = *info.model;
  require_surface(model, "glb");
  if (info.glb.stride == 0) throw base::BakeError("glb: the stride is 0; it must be at least 1");
  read_character(info);
  primitives_ = primitive_count(document_.json, rig_);
  // With an error bound, the number of targets depends on the motion.
  require_listable(info.glb.error ? 1 : glb_target_count(info.frames, info.glb));
  normals_.emplace(model, objects_of(info)->normals);
  choice_.emplace(rig_.parts, info.frames, info.glb.stride, info.glb.error);
  const std::array<float, 6> box = bounds(world_positions(embed(model, model.rest), model.unit, {0, 0, 0}));
  const Vector3d diagonal(double{box[3]} - double{box[0]}, double{box[4]} - double{box[1]},
                          double{box[5]} - double{box[2]});
  tolerance_ = info.glb.tolerance.value_or(default_tolerance * diagonal.norm());
  if (info.glb.compress) compression_.emplace(rig_, document_.json, stretch(), *info.glb.compress);
  stream_.emplace(base::SpoolFile::start(info.folder / glb_spool));
}

// A joint's transform times its inverse bind.
Matrix4d GlbSink::slot_at(const gltf::RigPart& part, std::size_t slot, const std::vector<Matrix4d>& joints,
                          std::uint64_t frame) const {
  const Matrix4d map = joints[part.skin_joint[slot]] * part.inverse_bind[slot];
  if (!(map.cwiseAbs().maxCoeff<Eigen::PropagateNaN>() <= most_of_joint))
    throw base::BakeError(
        info_.character.string() + ": frame " + base::number_text(frame) +
        ": a joint is not finite, or absurdly large; correct the sizes in its clip, or leave "
        "glb out, and bake again with --overwrite");
  return map;
}

// Per part: the largest factor by which its joints lengthen a vector in any frame. A blend stretches no more
// than the joint that stretches most.
std::vector<double> GlbSink::stretch() const {
  std::vector<double> most(rig_.parts.size(), 0.0);
  const bool has_clip = has_baked_clip(document_.json);
  for (std::uint64_t k = 0; k <= info_.frames; ++k) {
    const std::vector<Matrix4d> joints = baked_joints(rig_, has_clip, k, info_.fps);
    for (std::size_t p = 0; p < most.size(); ++p) {
      const gltf::RigPart& part = rig_.parts[p];
      if (part.influence_offset.empty()) most[p] = 1.0;
      for (std::size_t slot = 0; slot < part.skin_joint.size(); ++slot) {
        const Matrix3d map = slot_at(part, slot, joints, k).topLeftCorner<3, 3>();
        const Eigen::SelfAdjointEigenSolver<Matrix3d> squares(map.transpose() * map, Eigen::EigenvaluesOnly);
        most[p] = std::max(most[p], std::sqrt(std::max(squares.eigenvalues()[2], 0.0)));
      }
    }
  }
  return most;
}

void GlbSink::write(const model::Frame& frame) {
  // Without an error bound, frames between targets only count towards the reported error.
  for (const GlbFrame& target : choice_->next(frame_of(frame))) write_target(target);
}

GlbFrame GlbSink::frame_of(const model::Frame& frame) const {
  const model::Model& model = *info_.model;
  const std::size_t count = model.surface_count();
  const std::vector<Matrix4d> joints =
      baked_joints(rig_, has_baked_clip(document_.json), frame.index, info_.fps);
  GlbFrame result;
  result.index = frame.index;
  std::vector<Vector3d> away(count);
  std::vector<Matrix3d> blends(count);
  std::vector<float> skinned_values;
  std::size_t vertex = 0;
  for (const gltf::RigPart& part : rig_.parts) {
    std::vector<Matrix4d>& slots = result.slots.emplace_back();
    for (std::size_t k = 0; k < part.skin_joint.size(); ++k)
      slots.push_back(slot_at(part, k, joints, frame.index));
    for (std::size_t i = 0; i < part.positions.size(); ++i, ++vertex) {
      const Matrix4d blend = blend_of(part, slots, i);
      blends[vertex] = blend.topLeftCorner<3, 3>();
      const Vector3d skinned = blends[vertex] * part.positions[i] + blend.topRightCorner<3, 1>();
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto a = static_cast<Eigen::Index>(axis);
        away[vertex][a] =
            frame.origin[axis] + model.unit * double{frame.surface[3 * vertex + axis]} - skinned[a];
        // Relative to the frame's origin: far from the world origin, floats are too coarse for normals.
        skinned_values.push_back(static_cast<float>((skinned[a] - frame.origin[axis]) / model.unit));
      }
    }
  }
  const std::vector<float> normals = normals_->of(frame.surface);
  const std::vector<float> smooth = normals_->smooth_of(frame.surface);
  const std::vector<float> smooth_skinned = normals_->smooth_of(skinned_values);
  vertex = 0;
  for (std::size_t p = 0; p < rig_.parts.size(); ++p) {
    const gltf::RigPart& part = rig_.parts[p];
    const std::vector<char> uneven = below_uneven_joints(part, result.slots[p], least_turn);
    for (std::size_t i = 0; i < part.positions.size(); ++i, ++vertex) {
      const Matrix3d& linear = blends[vertex];
      const Vector3d move = rig::solve(linear, away[vertex]);
      result.moved.push_back(away[vertex].norm() > tolerance_ ? 1 : 0);
      // The change of the normal that a viewer's skinning maps to the wanted normal. The difference of unit
      // normals approximates the angle.
      Vector3d turn = Vector3d::Zero();
      const Vector3d wanted = part.normals.empty() ? turn : vector_at(normals, vertex);
      const auto is_turned = [&] {
        return (vector_at(smooth, vertex) - vector_at(smooth_skinned, vertex)).norm() > least_turn ||
               (uneven[i] != 0 && ((linear * part.normals[i]).normalized() - wanted).norm() > least_turn);
      };
      if (!part.normals.empty() && is_turned())
        turn = rig::solve(linear, wanted).normalized() - part.normals[i];
      const bool has_move = is_stored(move), has_turn = turn.allFinite();
      if (!has_move) result.moved.back() = 0;
      for (int axis = 0; axis < 3; ++axis) {
        result.moves.push_back(has_move ? static_cast<float>(move[axis]) : 0.0f);
        result.turns.push_back(has_turn ? static_cast<float>(turn[axis]) : 0.0f);
      }
    }
  }
  return result;
}

void GlbSink::write_target(const GlbFrame& frame) {
  if (targets_.size() == most_targets)
    throw base::BakeError("glb: more than " + base::number_text(std::uint64_t{most_targets}) +
                          " morph targets; give a larger --glb-stride or --glb-error");
  require_listable(targets_.size() + 1);
  targets_.push_back(frame.index);
  const std::string bytes = compression_ ? compression_->target(frame) : sparse_.target(frame);
  stream_->write(bytes);
  stream_bytes_ += bytes.size();
}

// Adds the targets to the primitives, and their weights to the animation.
void GlbSink::add_targets(json& document, const std::vector<std::size_t>& meshes) {
  const std::size_t count = targets_.size();
  const std::uint64_t keys = count;
  std::vector<float> times;
  std::string diagonal, ones;
  for (std::uint64_t k = 0; k < keys; ++k) {
    times.push_back(static_cast<float>(static_cast<double>(targets_[k]) / info_.fps));
    base::append_bytes(diagonal, static_cast<std::uint32_t>(k * keys + k));
    base::append_bytes(ones, 1.0f);
  }
  const std::size_t input = add_accessor(document_, std::span<const float>(times), 1, true);
  // Weight k is 1 at key k and 0 at all others.
  json& accessors = document["accessors"];
  const std::size_t indices = add_view(document_, diagonal), values = add_view(document_, ones);
  accessors.push_back({{"componentType", 5126},
                       {"count", keys * keys},
                       {"type", "SCALAR"},
                       {"sparse",
                        {{"count", keys},
                         {"indices", {{"bufferView", indices}, {"componentType", 5125}}},
                         {"values", {{"bufferView", values}}}}}});
  const std::size_t output = accessors.size() - 1;

  const bool has_clip = has_baked_clip(document);
  json& animations = document["animations"];
  if (!animations.is_array()) animations = json::array();
  drop_weight_channels(document, meshes, has_clip ? 1 : 0);
  if (!has_clip)
    animations.insert(animations.begin(),
                      json({{"name", "baked"}, {"samplers", json::array()}, {"channels", json::array()}}));
  json& animation = animations[0];
  const std::size_t sampler = animation["samplers"].size();
  animation["samplers"].push_back({{"input", input}, {"output", output}, {"interpolation", "LINEAR"}});

  add_still_targets(document, rig_, meshes, targets_.size());
  json names = json::array();
  for (const std::uint64_t frame : targets_)
    names.push_back("frame " + base::number_text(info_.first_number + frame));
  const std::size_t first = accessors.size();
  std::optional<std::uint32_t> node;
  for (std::size_t p = 0; p < rig_.parts.size(); ++p) {
    const gltf::RigPart& part = rig_.parts[p];
    json& shown = document["meshes"][meshes[p]];
    if (node != part.node) {
      node = part.node;
      if (!shown["extras"].is_object()) shown["extras"] = json::object();
      shown["extras"]["targetNames"] = names;
      shown.erase("weights");
      document["nodes"][part.node].erase("weights");
      animation["channels"].push_back(
          {{"sampler", sampler}, {"target", {{"node", part.node}, {"path", "weights"}}}});
    }
    shown["primitives"][part.primitive]["targets"] =
        compression_ ? compression_->targets_of(p, first) : sparse_.targets_of(p, first);
  }
}

void GlbSink::finish() {
  json& document = document_.json;
  const std::vector<std::size_t> meshes = own_meshes(document, rig_);
  if (compression_) compression_->quantise(document_, meshes);
  add_targets(document, meshes);
  if (!document["extras"].is_object()) document["extras"] = json::object();
  json& extras = document["extras"]["fascicle"];
  if (!extras.is_object()) extras = json::object();
  extras["first_frame"] = info_.first_number;
  extras["interpolation_error"] = choice_->error();
  if (compression_) extras["quantisation_error"] = compression_->error();
  std::string targets;
  std::string& binary = document_.binary;
  binary.resize((binary.size() + 3) / 4 * 4, '\0');
  if (compression_) {
    targets = compression_->accessors(document["bufferViews"].size());
    compression_->pack(document_, stream_bytes_);
  } else {
    targets = sparse_.accessors(document, binary.size());
    document["buffers"] = json::array({{{"byteLength", binary.size() + stream_bytes_}}});
  }
  require_finite(document);
  const std::uint64_t total = binary.size() + stream_bytes_;
  std::string accessors = document["accessors"].dump();
  document.erase("accessors");
  accessors.pop_back();
  std::string text = document.dump(-1, ' ', false, json::error_handler_t::replace);
  text.pop_back();
  text += ",\"accessors\":" + accessors + targets + "]}";
  base::PartFile file = base::PartFile::start(info_.folder / "surface.glb");
  file.write(glb_head(std::move(text), total));
  file.write(binary);
  stream_->move_to(file);
  file.finish();
}

SinkReport GlbSink::report() const {
  SinkReport report;
  const std::uint64_t count = targets_.size(), frames = info_.frames + 1;
  if (count < frames)
    report.notes.push_back("surface.glb: " + base::number_text(count) + " morph targets for " +
                           base::number_text(frames) + " frames; between them a viewer is off by at most " +
                           base::number_text(std::round(choice_->error() * 1e5) / 1e2) + " mm");
  if (compression_)
    report.notes.push_back("surface.glb: quantised, which moves a vertex by at most " +
                           base::number_text(std::round(compression_->error() * 1e6) / 1e3) +
                           " mm, and compressed");
  if (count > most_in_browsers)
    report.warnings.push_back("surface.glb has " + base::number_text(count) +
                              " morph targets; viewers in browsers (WebGL 2) load at most " +
                              base::number_text(std::uint64_t{most_in_browsers}) +
                              "; try --glb-error 0.002, which writes only as many as keep within 2 mm, "
                              "or --glb-stride " +
                              base::number_text((frames + most_in_browsers - 2) / (most_in_browsers - 1)));
  return report;
}

// Upper bound for this number of morph targets; vertices that only follow the skeleton take no space.
std::uint64_t glb_bytes(const model::Model& model, std::uint64_t targets) {
  // Worst case: every vertex in every target, with its index; about 700 bytes of JSON per target; the
  // character with about 64 bytes per vertex and 12 per triangle.
  return targets * (700 + std::uint64_t{28} * model.surface_count()) + 4000 +
         std::uint64_t{64} * model.surface_count() + model.surface_triangle.size() * 4;
}

}  // namespace

Format glb_format() {
  return {.name = "glb",
          .file = "surface.glb",
          .make = make_sink<GlbSink>,
          .bytes = glb_bytes,
          .beside = {glb_spool}};
}

}  // namespace fascicle::formats
