// SPDX-License-Identifier: MIT
#include "render/commands.hpp"

#include <exception>
#include <iostream>

int main(int argument_count, char** arguments) {
    CLI::App program("Renders scenes with shadows by light meshes and by what they are compared with.",
                     "lightmesh-render");
    program.require_subcommand(1);
    int status = 0;
    demo::add_picture_command(program, status);
    demo::add_film_command(program, status);
    demo::add_compare_command(program, status);
    demo::add_tables_command(program, status);
    demo::add_info_command(program, status);
    try {
        program.parse(argument_count, arguments);
    } catch (const CLI::ParseError& error) {
        if (error.get_exit_code() == 0)
            return program.exit(error);
        std::cerr << "lightmesh-render: " << error.what() << " (see --help)\n";
        return 2;
    } catch (const std::exception& error) {
        std::cerr << "lightmesh-render: " << error.what() << '\n';
        return 1;
    }
    if (!std::cout.flush()) {
        std::cerr << "lightmesh-render: cannot write to the standard output\n";
        return 1;
    }
    return status;
}
