#include "tests/bake/traced_disk.h"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <fstream>
#include <optional>
#include <set>
#include <sstream>
#include <stdexcept>
#include <string_view>

#include <unistd.h>

namespace fascicle::tests {
namespace {

namespace fs = std::filesystem;

// strace -xx writes all text as \xNN.
std::string unescaped(std::string_view text) {
  std::string bytes;
  for (std::size_t k = 0; k < text.size();) {
    if (text.substr(k, 2) == "\\x" && k + 4 <= text.size()) {
      unsigned value = 0;
      std::from_chars(text.data() + k + 2, text.data() + k + 4, value, 16);
      bytes += static_cast<char>(value);
      k += 4;
    } else {
      bytes += text[k++];
    }
  }
  return bytes;
}

// A line without its process ID: name(arguments) = result.
struct TracedLine {
  std::string name;
  std::vector<std::string> arguments;
  std::string result;
};

std::optional<TracedLine> parse_line(const std::string& line) {
  const std::size_t open = line.find('('), end = line.rfind(" = ");
  if (open == std::string::npos || end == std::string::npos || end < open) return std::nullopt;
  const std::size_t close = line.rfind(')', end);
  TracedLine traced{line.substr(0, open), {}, line.substr(end + 3)};
  std::string one;
  for (std::size_t k = open + 1; k < close; ++k) {
    if (line[k] == ',' && k + 1 < close && line[k + 1] == ' ') {
      traced.arguments.push_back(std::move(one));
      one.clear();
      ++k;
    } else {
      one += line[k];
    }
  }
  traced.arguments.push_back(std::move(one));
  return traced;
}

// The text between two delimiters, as in "TEXT" and 3<PATH>.
std::string between(const std::string& text, char first, char last) {
  const std::size_t begin = text.find(first), end = text.rfind(last);
  if (begin == std::string::npos || end == std::string::npos || end <= begin) return "";
  return unescaped(std::string_view(text).substr(begin + 1, end - begin - 1));
}

std::uint64_t number_in(const std::string& text) {
  std::uint64_t value = 0;
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

std::optional<DiskCall> call_of(const TracedLine& line) {
  const auto& [name, arguments, result] = line;
  if (result.starts_with("-1")) return std::nullopt;
  const std::string by_descriptor = between(arguments.at(0), '<', '>');
  if (name == "openat") {
    // Files created or truncated; O_TRUNC truncates an existing file.
    if (arguments.at(2).find("O_CREAT") == std::string::npos) return std::nullopt;
    return DiskCall{DiskCall::Kind::create, between(arguments.at(1), '"', '"'), {}, {}, 0};
  }
  const auto length = [&](const std::string& bytes) { return bytes.substr(0, number_in(result)); };
  if (name == "write")
    return DiskCall{
        DiskCall::Kind::write, by_descriptor, {}, length(between(arguments.at(1), '"', '"')), append};
  if (name == "pwrite64")
    return DiskCall{DiskCall::Kind::write,
                    by_descriptor,
                    {},
                    length(between(arguments.at(1), '"', '"')),
                    number_in(arguments.at(3))};
  if (name == "ftruncate")
    return DiskCall{DiskCall::Kind::truncate, by_descriptor, {}, {}, number_in(arguments.at(1))};
  if (name == "fsync" || name == "fdatasync") return DiskCall{DiskCall::Kind::sync, by_descriptor, {}, {}, 0};
  if (name == "rename")
    return DiskCall{DiskCall::Kind::rename,
                    between(arguments.at(0), '"', '"'),
                    between(arguments.at(1), '"', '"'),
                    {},
                    0};
  if (name == "renameat" || name == "renameat2")
    return DiskCall{DiskCall::Kind::rename,
                    between(arguments.at(1), '"', '"'),
                    between(arguments.at(3), '"', '"'),
                    {},
                    0};
  if (name == "unlink" || name == "rmdir")
    return DiskCall{DiskCall::Kind::remove, between(arguments.at(0), '"', '"'), {}, {}, 0};
  if (name == "unlinkat")
    return DiskCall{DiskCall::Kind::remove, between(arguments.at(1), '"', '"'), {}, {}, 0};
  if (name == "mkdir")
    return DiskCall{DiskCall::Kind::make_folder, between(arguments.at(0), '"', '"'), {}, {}, 0};
  throw std::runtime_error("a call that the model of the disk does not know: " + name);
}

std::string in_shell_quotes(const std::string& text) {
  return '\'' + text + '\'';
}

constexpr const char* traced_calls =
    "openat,write,pwrite64,writev,pwritev,pwritev2,ftruncate,truncate,fsync,fdatasync,rename,renameat,"
    "renameat2,unlink,unlinkat,rmdir,mkdir,mkdirat,link,linkat,symlink,symlinkat,copy_file_range,sendfile";

}  // namespace

std::string why_no_strace() {
  if (std::system("command -v strace > /dev/null 2>&1") != 0) return "strace is not installed";
  if (std::system("strace -o /dev/null true > /dev/null 2>&1") != 0) return "no process may be traced here";
  return "";
}

std::vector<DiskCall> traced(const std::string& command, const fs::path& folder) {
  const std::string log = folder.string() + ".strace", output = folder.string() + ".output";
  // Leak detection attaches like a debugger, and a process can have only one.
  const std::string run =
      "ASAN_OPTIONS=\"$ASAN_OPTIONS:detect_leaks=0\" strace -f -y -xx -s 100000000 -e trace=" +
      std::string(traced_calls) + " -o " + in_shell_quotes(log) + " sh -c " + in_shell_quotes(command) +
      " > " + in_shell_quotes(output) + " 2>&1 < /dev/null";
  if (std::system(run.c_str()) != 0) {
    std::ostringstream said;
    said << std::ifstream(output).rdbuf();
    throw std::runtime_error(command + ": failed: " + said.str());
  }
  std::vector<DiskCall> calls;
  std::map<std::string, std::string> unfinished;  // by process ID
  std::ifstream in(log);
  for (std::string line; std::getline(in, line);) {
    const std::size_t space = line.find_first_not_of("0123456789");
    const std::string process = line.substr(0, space);
    std::string rest = line.substr(line.find_first_not_of(' ', space));
    if (const std::size_t mark = rest.find(" <unfinished ...>"); mark != std::string::npos) {
      unfinished[process] = rest.substr(0, mark);
      continue;
    }
    // A call takes effect when it returns; nothing is guaranteed before that.
    if (rest.starts_with("<... ")) rest = unfinished[process] + rest.substr(rest.find("resumed>") + 8);
    const std::optional<TracedLine> parsed = parse_line(rest);
    if (!parsed) continue;
    const auto is_ours = [&](const std::string& path) {
      return path == folder.string() || path == folder.parent_path() ||
             path.starts_with(folder.string() + '/');
    };
    const bool is_there =
        std::any_of(parsed->arguments.begin(), parsed->arguments.end(), [&](const std::string& argument) {
          return is_ours(between(argument, '"', '"')) || is_ours(between(argument, '<', '>'));
        });
    if (!is_there) continue;
    if (std::optional<DiskCall> call = call_of(*parsed)) calls.push_back(std::move(*call));
  }
  return calls;
}

Disk::Disk(fs::path folder) : folder_(folder.string()) {
  const std::string above = fs::path(folder_).parent_path().string();
  latest_[above] = safe_[above] = std::make_shared<Inode>(Inode{true, false, {}, {}});
}

std::string Disk::relative(const std::string& path) const {
  return path.size() > folder_.size() ? path.substr(folder_.size() + 1) : "";
}

void Disk::apply(const DiskCall& call) {
  const auto inode = [&]() -> Inode& {
    const auto found = latest_.find(call.path);
    if (found == latest_.end()) throw std::runtime_error("a write to what has no name: " + call.path);
    return *found->second;
  };
  switch (call.kind) {
    case DiskCall::Kind::create:
      // An existing file is truncated and keeps its inode.
      if (const auto found = latest_.find(call.path); found != latest_.end()) {
        found->second->bytes.clear();
        found->second->is_dirty = true;
      } else {
        latest_[call.path] = std::make_shared<Inode>();
      }
      break;
    case DiskCall::Kind::write: {
      Inode& file = inode();
      const std::size_t at = call.offset == append ? file.bytes.size() : call.offset;
      file.bytes.resize(std::max(file.bytes.size(), at + call.bytes.size()));
      file.bytes.replace(at, call.bytes.size(), call.bytes);
      file.is_dirty = true;
      break;
    }
    case DiskCall::Kind::truncate:
      inode().bytes.resize(call.offset);
      inode().is_dirty = true;
      break;
    case DiskCall::Kind::sync: {
      Inode& synced = inode();
      synced.safe_bytes = synced.bytes;
      synced.is_dirty = false;
      if (!synced.is_folder) break;
      const auto is_in_it = [&](const auto& entry) {
        return fs::path(entry.first).parent_path() == call.path;
      };
      std::erase_if(safe_, is_in_it);
      for (const auto& entry : latest_)
        if (is_in_it(entry)) safe_.insert(entry);
      break;
    }
    case DiskCall::Kind::rename: {
      const auto node = latest_.extract(call.path);
      if (node.empty()) throw std::runtime_error("a rename of what has no name: " + call.path);
      latest_[call.to] = node.mapped();
      break;
    }
    case DiskCall::Kind::remove:
      latest_.erase(call.path);
      break;
    case DiskCall::Kind::make_folder:
      latest_[call.path] = std::make_shared<Inode>(Inode{true, false, {}, {}});
      break;
  }
}

// A name is safe only if its folder's name is safe too.
bool Disk::is_below_safe(const std::string& path) const {
  for (fs::path above = fs::path(path).parent_path(); above.string().size() >= folder_.size();
       above = above.parent_path())
    if (!safe_.contains(above.string())) return false;
  return true;
}

Disk::Files Disk::after_power_cut(Names names) const {
  Files files;
  for (const auto& [path, inode] : names == Names::safe ? safe_ : latest_)
    if (!inode->is_folder && (names == Names::latest || is_below_safe(path)))
      files[relative(path)] = inode->safe_bytes;
  return files;
}

std::vector<std::string> Disk::unsafe() const {
  std::vector<std::string> names;
  for (const auto& [path, inode] : latest_) {
    const auto known = safe_.find(path);
    if (path.size() < folder_.size()) continue;
    if (inode->is_dirty || known == safe_.end() || known->second != inode || !is_below_safe(path))
      names.push_back(relative(path));
  }
  return names;
}

bool Disk::is_dirty(const std::string& path) const {
  const auto found = latest_.find(path);
  return found != latest_.end() && found->second->is_dirty;
}

std::string Disk::content(const std::string& path) const {
  const auto found = latest_.find(path);
  return found == latest_.end() ? "" : found->second->bytes;
}

std::vector<std::string> wrong_orders(const std::vector<DiskCall>& calls, const fs::path& folder,
                                      const std::function<bool(const std::string&, bool)>& counts) {
  Disk disk(folder);
  std::vector<std::string> wrong;
  for (const DiskCall& call : calls) {
    if (call.kind == DiskCall::Kind::rename && disk.is_dirty(call.path))
      wrong.push_back(call.to + " has its name before its bytes are safe");
    const std::string name = call.kind == DiskCall::Kind::rename ? fs::path(call.to).filename().string() : "";
    if (name == "manifest.json" || name == "checkpoint") {
      const bool at_end = disk.content(call.path).find("\"status\": \"complete\"") != std::string::npos;
      for (const std::string& one : disk.unsafe()) {
        const bool is_itself = fs::path(one).stem() == name || one == name;
        if (!is_itself && counts(one, at_end))
          wrong.push_back(name + " counts on " + one + ", which is not safe");
      }
    }
    disk.apply(call);
  }
  for (const std::string& one : disk.unsafe()) wrong.push_back(one + " is not safe at the end");
  return wrong;
}

}  // namespace fascicle::tests
