// fascicle-mesher: reports what is wrong with surfaces, wraps them, and fills closed ones with tetrahedra.
#include <charconv>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include <CGAL/version.h>
#include <fcntl.h>
#include <unistd.h>

#include "host/base/pending_output.h"
#include "host/base/sandbox.h"
#include "host/mesher/exit_codes.h"
#include "host/mesher/files.h"
#include "host/mesher/surface_check.h"
#include "host/mesher/surface_report.h"
#include "host/mesher/tetgen_run.h"
#include "host/mesher/wrap.h"

namespace fascicle::mesher {
namespace {

constexpr const char* help =
    "fascicle-mesher fills closed surfaces with tetrahedra (TetGen), and wraps and examines any (CGAL).\n"
    "Licence of this program: AGPL-3.0.\n"
    "\n"
    "  fascicle-mesher tetrahedralize IN.off OUT.mesh [--max-volume V] [--quality Q] [--points FILE]\n"
    "      Keeps the surface's vertices (first, in order) and triangles. V: largest tetrahedron, in the "
    "file's unit\n"
    "      cubed. Q: largest ratio of circumradius to shortest edge, at least 1 (default 1.4). FILE: a "
    "count, then\n"
    "      x y z of points that become vertices where they lie inside.\n"
    "  fascicle-mesher intersections IN.off\n"
    "      Says where the surface crosses itself.\n"
    "  fascicle-mesher report IN.off OUT.txt\n"
    "      Writes what is wrong with any surface: parts, open, non-manifold and turned edges, crossings, "
    "genus;\n"
    "      a line each, with a count and vertices of the first places.\n"
    "  fascicle-mesher wrap IN.off OUT.off --alpha A [--offset O] [--edge L | --vertices N]\n"
    "      Writes a closed surface around any surface, at a distance of about O (default A/30), that closes "
    "gaps\n"
    "      and holes narrower than about 2 A; of triangles with sides of about L, or such that about N "
    "vertices fill "
    "it.\n"
    "      If such triangles cross at thin parts, A is L and O is at least L/3. The last line on stderr has "
    "the A\n"
    "      and O used.\n"
    "  fascicle-mesher --help | --version\n"
    "\n"
    "Exit status: 0 done, 2 bad usage, 3 a file cannot be read, 4 the surface is not closed, 5 it crosses "
    "itself,\n"
    "6 out of memory, 7 TetGen failed, 8 no tetrahedra came out, 9 the result cannot be written, 10 the "
    "surface\n"
    "cannot be wrapped.\n";

struct Options {
  std::string input, output, points;
  double max_volume = 0.0;
  double quality = 1.4;
  WrapSettings wrap;
};

constexpr double smallest_length = 1e-30;

double number_option(const std::string& name, std::string_view text, double minimum) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(value) || value < minimum) {
    throw Failure(bad_usage, name + " needs a number, not \"" + std::string(text) + "\"");
  }
  return value;
}

Options parse_options(const std::vector<std::string>& arguments, std::size_t file_count) {
  Options options;
  std::vector<std::string> files;
  for (std::size_t i = 1; i < arguments.size(); ++i) {
    const std::string& word = arguments[i];
    if (word.rfind("--", 0) != 0) {
      files.push_back(word);
      continue;
    }
    if (i + 1 == arguments.size()) throw Failure(bad_usage, word + " needs a value; see --help");
    const std::string& value = arguments[++i];
    if (word == "--max-volume") {
      options.max_volume = number_option(word, value, 0.0);
    } else if (word == "--quality") {
      options.quality = number_option(word, value, 1.0);
    } else if (word == "--points") {
      options.points = value;
    } else if (word == "--alpha") {
      options.wrap.alpha = number_option(word, value, smallest_length);
    } else if (word == "--offset") {
      options.wrap.offset = number_option(word, value, smallest_length);
    } else if (word == "--edge") {
      options.wrap.edge = number_option(word, value, smallest_length);
    } else if (word == "--vertices") {
      options.wrap.vertices = static_cast<std::size_t>(number_option(word, value, 4.0));
    } else {
      throw Failure(bad_usage, "no option " + word + "; see --help");
    }
  }
  if (files.size() != file_count) {
    throw Failure(bad_usage, "expected " + std::to_string(file_count) + " file names; see --help");
  }
  options.input = files[0];
  if (file_count > 1) options.output = files[1];
  return options;
}

// The files are untrusted, and TetGen and CGAL were not written for untrusted input.
void enter_sandbox(const Options& options) {
  base::enter_sandbox({options.input, options.points}, options.output);
}

// Reads and computes in the sandbox, then writes the result of `text`.
template <class Text>
void write_from_sandbox(const Options& options, const Text& text) {
  try {
    base::PendingOutput output(options.output);
    install_terminate_handler(output.part());
    enter_sandbox(options);
    output.finish(text());
  } catch (const std::system_error& error) {
    throw Failure(cannot_write, error.what());
  }
}

void run_tetrahedralize(const Options& options) {
  write_from_sandbox(options, [&] {
    const Surface surface = read_surface(options.input);
    std::vector<Point> inside;
    if (!options.points.empty()) inside = read_points(options.points);
    check_closed(surface);
    const Volume volume = fill(surface, inside, options.max_volume, options.quality);
    if (volume.tetrahedra.empty()) throw Failure(empty_result, "TetGen made no tetrahedra");
    return text_of(volume);
  });
}

void run_intersections(const Options& options) {
  // Opened before the sandbox, which does not allow temporary files.
  std::FILE* const listed = std::tmpfile();
  if (listed == nullptr) throw Failure(cannot_write, "no temporary file");
  enter_sandbox(options);
  const Surface surface = read_surface(options.input);
  if (const auto where = find_intersection(surface, listed)) throw Failure(self_intersecting, *where);
}

void run_report(const Options& options) {
  write_from_sandbox(options, [&] { return text_of(report_surface(read_surface(options.input))); });
}

void run_wrap(const Options& options) {
  constexpr double offset_of_alpha = 1.0 / 30.0;
  WrapSettings settings = options.wrap;
  if (settings.alpha == 0.0) throw Failure(bad_usage, "wrap needs --alpha; see --help");
  if (settings.offset == 0.0) settings.offset = offset_of_alpha * settings.alpha;
  if (settings.edge && settings.vertices)
    throw Failure(bad_usage, "--edge and --vertices exclude each other");
  Wrap found;
  write_from_sandbox(options, [&] {
    found = wrap(read_surface(options.input), settings);
    return text_of(found.surface);
  });
  std::fprintf(stderr, "fascicle-mesher: alpha %s offset %s\n", text_of(found.alpha).c_str(),
               text_of(found.offset).c_str());
}

int run(const std::vector<std::string>& arguments) {
  const std::string command = arguments.empty() ? "" : arguments[0];
  if (command == "--help" || command == "-h") {
    std::fputs(help, stdout);
  } else if (command == "--version") {
    std::puts("fascicle-mesher " FASCICLE_VERSION " (TetGen 1.5 and CGAL " CGAL_VERSION_STR ", AGPL-3.0)");
    std::printf("sandbox: %s\n", base::sandbox_words().c_str());
  } else if (command == "tetrahedralize") {
    run_tetrahedralize(parse_options(arguments, 2));
  } else if (command == "intersections") {
    run_intersections(parse_options(arguments, 1));
  } else if (command == "report") {
    run_report(parse_options(arguments, 2));
  } else if (command == "wrap") {
    run_wrap(parse_options(arguments, 2));
  } else {
    throw Failure(bad_usage, "expected tetrahedralize, intersections, report or wrap; see --help");
  }
  return done;
}

// Opens standard input, output and error on /dev/null if they are closed: otherwise the next files opened
// would get their numbers. Makes a write beyond the file size limit fail, as on a full disk.
void prepare() {
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (::fcntl(stream, F_GETFD) < 0 && ::open("/dev/null", O_RDWR) != stream) std::_Exit(EXIT_FAILURE);
  std::signal(SIGXFSZ, SIG_IGN);
}

}  // namespace
}  // namespace fascicle::mesher

int main(int argument_count, char** arguments) {
  fascicle::mesher::prepare();
  // Catches only Failure: exceptions from TetGen must reach the terminate handler (tetgen_run.h).
  fascicle::mesher::install_terminate_handler("");
  try {
    return fascicle::mesher::run(std::vector<std::string>(arguments + 1, arguments + argument_count));
  } catch (const fascicle::mesher::Failure& failure) {
    std::fprintf(stderr, "fascicle-mesher: %s\n", failure.what());
    return failure.exit_code;
  }
}
