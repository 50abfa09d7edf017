// SPDX-License-Identifier: MIT
#include "isolated.hpp"

#include "model_archive.hpp"

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <exception>
#include <fstream>
#include <new>
#include <stdexcept>
#include <string>

namespace demo {
namespace {

struct Broken : std::exception {};

/// The two ends of a pipe, as files.
class Writer {
public:
    explicit Writer(std::FILE* pipe) : pipe_(pipe) {}
    void bytes(const void* data, std::size_t size) {
        if (size != 0 && std::fwrite(data, 1, size, pipe_) != size)
            throw Broken();
    }
    template <class Container>
    void resize(const Container& container) {
        const std::uint64_t size = container.size();
        bytes(&size, sizeof size);
    }

private:
    std::FILE* pipe_;
};

class PipeReader {
public:
    explicit PipeReader(std::FILE* pipe) : pipe_(pipe) {}
    void bytes(void* data, std::size_t size) {
        if (size != 0 && std::fread(data, 1, size, pipe_) != size)
            throw Broken();
    }
    template <class Container>
    void resize(Container& container) {
        std::uint64_t size = 0;
        bytes(&size, sizeof size);
        container.resize(size);
    }

private:
    std::FILE* pipe_;
};

enum class Outcome : char { read, refused, out_of_memory };

/// Private memory that the process has, in bytes: what RLIMIT_DATA counts.
std::size_t data_in_use() {
    std::ifstream status("/proc/self/status");
    std::string word;
    std::size_t kilobytes = 0;
    while (status >> word)
        if (word == "VmData:" && status >> kilobytes)
            return kilobytes * 1024;
    return 0;
}

void set_limit(int resource, std::size_t value) {
    rlimit limit{};
    getrlimit(static_cast<__rlimit_resource>(resource), &limit);
    limit.rlim_cur = (std::min)(static_cast<rlim_t>(value), limit.rlim_max);
    setrlimit(static_cast<__rlimit_resource>(resource), &limit);
}

/// The limits on private memory of a child, in bytes: now, and as far as they may be raised; 0 elsewhere.
std::size_t allowed_data = 0;
std::size_t most_data = 0;

/// The child: reads the file, writes what it found, and ends without what the program does when it ends.
[[noreturn]] void read_and_exit(const std::function<Model()>& reader, const ReaderLimits& limits,
                                int pipe_end) {
    std::signal(SIGINT, SIG_DFL);
    std::signal(SIGTERM, SIG_DFL);
    set_limit(RLIMIT_CORE, 0);
    set_limit(RLIMIT_CPU, limits.seconds);
    if (const std::size_t used = data_in_use(); used > 0) {
        allowed_data = used + limits.bytes;
        most_data = used + (std::max)(limits.bytes, limits.most_bytes);
        set_limit(RLIMIT_DATA, allowed_data);
    }
    // Libraries print what they like; the program has its own words.
    if (std::freopen("/dev/null", "w", stderr) == nullptr ||
        std::freopen("/dev/null", "w", stdout) == nullptr)
        _exit(1);
    std::FILE* pipe = fdopen(pipe_end, "wb");
    Writer writer(pipe);
    Outcome outcome = Outcome::refused;
    std::string problem;
    const std::size_t used = allowed_data - (std::min)(allowed_data, limits.bytes);
    try {
        Model model = reader();
        outcome = Outcome::read;
        exchange(writer, outcome);
        exchange(writer, model);
    } catch (const std::bad_alloc&) {
        outcome = Outcome::out_of_memory;
        exchange(writer, outcome);
        std::size_t taken = allowed_data - used;
        exchange(writer, taken);
    } catch (const std::exception& error) {
        problem = error.what();
        exchange(writer, outcome);
        exchange(writer, problem);
    }
    std::fclose(pipe);
    _exit(0);
}

std::string megabytes(std::size_t bytes) {
    return std::to_string(bytes >> 20) + " MB";
}

std::string problem_of(int status, const ReaderLimits& limits) {
    if (WIFSIGNALED(status) && (WTERMSIG(status) == SIGXCPU || WTERMSIG(status) == SIGKILL))
        return "is not read after " + std::to_string(limits.seconds) + " seconds: damaged, or made to hang";
    if (WIFSIGNALED(status))
        return std::string("is damaged: the library that reads it crashed (") + strsignal(WTERMSIG(status)) +
               ")";
    return "is damaged: the library that reads it gave up";
}

}  // namespace

void allow_memory(std::size_t bytes) {
    if (most_data == 0)
        return;
    allowed_data += (std::min)(bytes, most_data - allowed_data);
    set_limit(RLIMIT_DATA, allowed_data);
}

void allow_file(std::size_t bytes) {
    if (most_data != 0)
        most_data += unpacked_factor * bytes;
    allow_memory(read_factor * bytes);
}

Model read_isolated(const std::function<Model()>& reader, const ReaderLimits& limits) {
    int ends[2];
    if (pipe(ends) != 0)
        throw std::runtime_error(std::string("cannot be read: ") + std::strerror(errno));
    std::fflush(stdout);
    std::fflush(stderr);
    const pid_t child = fork();
    if (child < 0) {
        close(ends[0]);
        close(ends[1]);
        throw std::runtime_error(std::string("cannot be read: ") + std::strerror(errno));
    }
    if (child == 0) {
        close(ends[0]);
        read_and_exit(reader, limits, ends[1]);
    }
    close(ends[1]);
    std::FILE* pipe = fdopen(ends[0], "rb");
    Model model;
    Outcome outcome = Outcome::refused;
    std::string problem;
    std::size_t taken = 0;
    bool whole = true;
    try {
        PipeReader source(pipe);
        exchange(source, outcome);
        if (outcome == Outcome::read)
            exchange(source, model);
        else if (outcome == Outcome::refused)
            exchange(source, problem);
        else
            exchange(source, taken);
    } catch (const Broken&) {
        whole = false;
    }
    std::fclose(pipe);
    int status = 0;
    while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    if (!whole)
        throw std::runtime_error(problem_of(status, limits));
    if (outcome == Outcome::out_of_memory)
        throw std::runtime_error("would take more than " + megabytes(taken) +
                                 " of memory to read: damaged, or made to fill it");
    if (outcome == Outcome::refused)
        throw std::runtime_error(problem);
    return model;
}

}  // namespace demo
