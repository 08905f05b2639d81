#include <filesystem>

#include "host/bake/outputs.h"
#include "host/bake/sealed_json.h"
#include "host/base/errors.h"
#include "host/base/json_text.h"
#include "host/cli/batch_plan.h"
#include "host/cli/batch_summary.h"
#include "host/cli/bench_results.h"
#include "host/cli/job_record.h"
#include "host/cli/metrics_table.h"
#include "host/cli/worst_frames.h"
#include "host/model/model.h"
#include "host/page/curves.h"
#include "host/scene/jobs.h"
#include "tests/fuzz/one_file.h"
#include "tests/fuzz/readers.h"
#include "tests/fuzz/taken.h"

namespace fascicle::fuzz {

bool metrics(std::string_view bytes) {
  static const OneFile file(bake::metrics_name);
  static const fascicle::model::Model model = [] {
    fascicle::model::Model made;
    made.joint_count = 1;
    made.layers.resize(1);
    made.layers[0].name = "fat";
    return made;
  }();
  file.write(bytes);
  (void)is_taken<base::BakeError>([] {
    const cli::FrameScores scores = cli::read_frame_scores(file.folder());
    (void)cli::worst_frames(scores, 100, 4, 3);
  });
  (void)is_taken<base::BakeError>([] { (void)page::read_curves(file.folder(), 100); });
  (void)bake::peak_lags(file.folder(), model);
  return is_taken<base::BakeError>([] { (void)cli::read_metrics_table(file.folder()); });
}

bool record(std::string_view bytes) {
  static const OneFile file("job.json");
  static const bool is_linked = [] {
    // Records are in a subfolder.
    const std::filesystem::path path = cli::job_record_file(file.folder(), "job");
    std::filesystem::create_directory_symlink(file.folder(), path.parent_path());
    return true;
  }();
  file.write(bytes);
  return is_linked && cli::read_job_record(file.folder(), "job").has_value();
}

bool batch(std::string_view bytes) {
  static const OneFile file(scene::batch_summary);
  file.write(bytes);
  const auto is_summary = [] {
    return is_taken<base::BakeError>([] { (void)cli::read_batch_summary(file.folder()); });
  };
  const bool is_whole = is_summary();
  const scene::Json object = scene::Json::parse(base::shallow_json(bytes), nullptr, false);
  if (!object.is_object() || !bake::is_damaged(object)) return is_whole;
  file.write(bake::sealed_text(object));
  return is_summary();
}

bool plan(std::string_view bytes) {
  static const OneFile file(cli::plan_file);
  file.write(bytes);
  return is_taken<base::BakeError>([] { (void)cli::find_plan(file.folder()); });
}

bool results(std::string_view bytes) {
  static const OneFile file("bench.json");
  file.write(bytes);
  return is_taken<base::BakeError>([] { (void)cli::read_bench_json(file.path()); });
}

}  // namespace fascicle::fuzz
