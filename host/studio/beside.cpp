#include "host/studio/beside.h"

#include <algorithm>
#include <cmath>
#include <exception>
#include <system_error>
#include <utility>

#include "host/bake/folder.h"
#include "host/base/errors.h"

namespace fascicle::studio {

namespace fs = std::filesystem;

namespace {

// A folder that cannot be read is not a bake.
bool is_bake(const fs::path& folder) {
  try {
    return bake::holds_bake(folder);
  } catch (const std::exception&) {
    return false;
  }
}

}  // namespace

std::vector<BesideChoice> beside_choices(const std::vector<fs::path>& given, const fs::path& session) {
  std::vector<BesideChoice> choices;
  for (const fs::path& folder : given) choices.push_back({folder.string(), folder});
  if (session.empty()) return choices;
  std::error_code error;
  std::vector<fs::path> own;
  for (fs::directory_iterator entry(session, error), end; !error && entry != end; entry.increment(error))
    if (std::error_code none; !entry->is_symlink(none) && entry->is_directory(none))
      own.push_back(entry->path());
  std::sort(own.begin(), own.end());
  for (const fs::path& folder : own) {
    const bool is_given = std::any_of(given.begin(), given.end(), [&](const fs::path& one) {
      std::error_code none;
      return fs::equivalent(one, folder, none);
    });
    if (!is_given && is_bake(folder)) choices.push_back({folder.string(), folder});
  }
  return choices;
}

BesideBake::BesideBake(BesideChoice choice) : choice_(std::move(choice)) {
  auto open = std::make_unique<pipeline::OpenBake>(choice_.folder);
  if (open->frame_count() == 0)
    throw base::BakeError(choice_.folder.string() + ": has no complete frame; bake it again");
  model_ = &open->model();
  arrays_ = shape_messages(*model_, "beside.");
  motion_ = std::make_unique<BakedMotion>(std::move(open), choice_.folder);
}

Json BesideBake::description() const {
  Json names = Json::array();
  for (const ArrayMessage& array : arrays_) names.push_back(array.name);
  Json bake{{"name", choice_.name},        {"fps", motion_->fps()},          {"start", motion_->start()},
            {"frames", motion_->frames()}, {"counts", counts_json(*model_)}, {"layers", layers_json(*model_)},
            {"arrays", std::move(names)}};
  if (!motion_->why_no_lag().empty()) bake["why_no_lag"] = motion_->why_no_lag();
  return bake;
}

ShownFrame BesideBake::at(double time) {
  const double last = static_cast<double>(motion_->frames());
  const double wanted = std::round((time - motion_->start()) * motion_->fps());
  const auto frame = static_cast<std::uint64_t>(std::clamp(wanted, 0.0, last));
  return frame == motion_->frame() ? motion_->again() : motion_->seek(frame);
}

}  // namespace fascicle::studio
