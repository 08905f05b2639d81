// What a helper program gives up before it reads an untrusted file.
#pragma once

#include <string>
#include <vector>

namespace fascicle::base {

// From now on the process may read the files `inputs`, write to what is already open, compute and exit. In
// the folder of `output` and below it (nowhere if `output` is empty) it may rename and remove files and
// create empty ones, which a PendingOutput needs to get its name. Landlock prevents it from opening anything
// else and from signalling other processes. seccomp prevents it from starting threads and programs, opening
// sockets, tracing, signalling any process but itself, having files send signals (fcntl), making memory
// executable and changing file permissions: such calls fail with EPERM. No program it executes could gain
// privileges (no_new_privs). None of this can be undone. On a kernel without Landlock or without seccomp, or
// on an architecture other than x86-64 and arm64, the respective part is skipped. A missing input is ignored
// here; opening it fails later. For single-threaded processes.
void enter_sandbox(const std::vector<std::string>& inputs, const std::string& output);

// What this kernel supports of it: "Landlock 4, seccomp", "seccomp" or "none".
std::string sandbox_words();

}  // namespace fascicle::base
