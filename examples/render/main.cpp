// SPDX-License-Identifier: MIT
#include "render/commands.hpp"

#include <exception>
#include <iostream>
#include <string>

namespace {

/// Rank 0 says why, and its exit status is all ranks': mpirun ends the others at once where one has another.
int fail(demo::Ranks& ranks, const std::string& why, int status) {
    if (ranks.is_first()) {
        std::cerr << why << std::endl;
        return status;
    }
    ranks.tell_failure(why, status == demo::exit_interrupted);
    return 0;
}

int run(demo::Ranks& ranks, int argument_count, char** arguments) {
    CLI::App program("Renders scenes with shadows by light meshes and by what they are compared with.",
                     "lightmesh-render");
    program.require_subcommand(1);
    int status = 0;
    demo::add_picture_command(program, ranks, status);
    demo::add_film_command(program, ranks, status);
    demo::add_compare_command(program, status);
    demo::add_tables_command(program, status);
    demo::add_info_command(program, status);
    for (const std::string name : {"compare", "tables", "info"})
        program.get_subcommand(name)->parse_complete_callback(
            [&ranks, name] { demo::require_one_rank(ranks, name); });
    const std::string start = ranks.is_first() ? "lightmesh-render: " : "";
    try {
        program.parse(argument_count, arguments);
    } catch (const CLI::ParseError& error) {
        if (error.get_exit_code() == 0)
            return ranks.is_first() ? program.exit(error) : 0;
        return fail(ranks, start + error.what() + " (see --help)", 2);
    } catch (const demo::Stopped&) {
        return 0;
    } catch (const demo::Interrupted& error) {
        return fail(ranks, start + "interrupted: " + error.what(), demo::exit_interrupted);
    } catch (const std::exception& error) {
        return fail(ranks, start + error.what(), 1);
    }
    if (!std::cout.flush())
        return fail(ranks, start + "cannot write to the standard output", 1);
    return ranks.is_first() ? status : 0;
}

}  // namespace

int main(int argument_count, char** arguments) {
    try {
        demo::Ranks ranks;
        return run(ranks, argument_count, arguments);
    } catch (const demo::Stopped&) {
        return 0;
    } catch (const std::exception& error) {
        std::cerr << "lightmesh-render: " << error.what() << '\n';
        return 1;
    }
}
