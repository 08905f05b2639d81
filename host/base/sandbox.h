// What a helper program gives up before it reads a stranger's file.
#pragma once

#include <string>
#include <vector>

namespace fascicle::base {

// From here on the process may read the files `inputs`, write what is open already, compute and end. In the
// folder of `output` and below it (nowhere, where that is empty) it may rename and remove files and make
// empty ones: a PendingOutput needs that to get its name. By Landlock it opens nothing else, and its signals
// reach no other process; by seccomp it starts no thread and no program, opens no socket, traces nobody,
// signals nobody but itself, lets no file signal (fcntl), makes no memory executable and changes no file's
// rights: the call fails with EPERM. It gains no rights by any program (no_new_privs). Nothing of it can be
// taken back. A kernel without Landlock, and one without seccomp or of another architecture than x86-64 and
// arm64, goes without; a file that is not there is left out, and opening it says so later. For a process of
// one thread.
void enter_sandbox(const std::vector<std::string>& inputs, const std::string& output);

// What this kernel has of it: "Landlock 4, seccomp", "seccomp" or "none".
std::string sandbox_words();

}  // namespace fascicle::base
