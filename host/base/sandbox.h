// What a helper program gives up before it reads a stranger's file.
#pragma once

#include <string>
#include <vector>

namespace fascicle::base {

// From here on the process may read the files `inputs`, write into the folder of `output` (nowhere, where
// that is empty), compute and end. By Landlock it opens nothing else; by seccomp it starts no thread and no
// program, opens no socket, traces nobody, signals nobody but itself, makes no memory executable and changes
// no file's rights: the call fails with EPERM. It gains no rights by any program (no_new_privs). What is open
// already stays. Nothing of it can be taken back. A kernel without Landlock or seccomp goes without; a file
// that is not there is left out, and opening it says so later. For a process of one thread.
void enter_sandbox(const std::vector<std::string>& inputs, const std::string& output);

// What this kernel has of it: "Landlock 4, seccomp", "seccomp" or "none".
std::string sandbox_words();

}  // namespace fascicle::base
