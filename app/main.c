#include <stdio.h>
#include <string.h>

#include "app.h"

static const struct command {
    const char *name, *summary;
    int (*run)(int argc, char **argv);
} commands[] = {
    {"render", "pictures of a scene: PNG or OpenEXR, one frame or many; or a video", gn_app_render},
    {"compare", "two methods on one view, or two picture files: pictures and numbers",
     gn_app_compare},
    {"bench", "time, steadiness and error of methods, as a table", gn_app_bench},
    {"report", "a page that compares the methods on scenes: pictures, plots, tables",
     gn_app_make_report},
    {"demo", "built-in scenes with the methods side by side, as pictures and a page", gn_app_demo},
    {"methods", "the ways of finding visibility, with their papers", gn_app_methods},
    {"histogram", "how the offset of the fourth moment spreads over a map, as numbers and a plot",
     gn_app_histogram},
    {"bounds", "the shadow that four moments promise, over depth", gn_app_bounds},
    {"mips", "what an alpha test makes of a texture's mips", gn_app_mips},
    {"scene", "write a built-in scene as .glb", gn_app_scene},
    {"info", "what a scene has, and what of it gnomon leaves out", gn_app_info},
};

#define COMMAND_COUNT (sizeof commands / sizeof *commands)

static void print_help(void)
{
    printf("gnomon: pixel-perfect, alias-free ray-traced hard shadows\n\n"
           "Usage: gnomon COMMAND [options]\n\nCommands:\n");
    for (size_t i = 0; i < COMMAND_COUNT; i++)
        printf("  %-10s%s\n", commands[i].name, commands[i].summary);
    printf("\n'gnomon COMMAND --help' tells more. A SCENE is a .glb, a .gltf, any other file that\n"
           "Assimp reads, or a built-in scene:");
    for (const gn_procedural *scene = gn_procedurals; scene->name; scene++)
        printf(" %s", scene->name);
    printf(".\n\nExamples:\n  gnomon render grove -o grove.png\n"
           "  gnomon compare grove --a ray-mip0 --b ray-coverage -o comparison\n");
}

int gn_app_command(int argc, char **argv)
{
    const char *names[COMMAND_COUNT + 1] = {NULL};
    for (size_t i = 0; i < COMMAND_COUNT; i++) {
        if (strcmp(commands[i].name, argv[0]) == 0)
            return commands[i].run(argc, argv);
        names[i] = commands[i].name;
    }
    const char *guess = gn_suggest(argv[0], names);
    if (guess)
        fprintf(stderr, "gnomon: no command '%s'; did you mean '%s'?\n", argv[0], guess);
    else
        fprintf(stderr, "gnomon: no command '%s'\n", argv[0]);
    fprintf(stderr, "Try 'gnomon --help'.\n");
    return GN_EXIT_USAGE;
}

int main(int argc, char **argv)
{
    const char *name = argc > 1 ? argv[1] : "--help";
    gn_app_catch_interrupts();
    if (strcmp(name, "--help") == 0 || strcmp(name, "-h") == 0 || strcmp(name, "help") == 0) {
        print_help();
        return argc > 1 ? GN_EXIT_OK : GN_EXIT_USAGE;
    }
    if (strcmp(name, "--version") == 0) {
        printf("gnomon %d.%d.%d\n", GN_VERSION_MAJOR, GN_VERSION_MINOR, GN_VERSION_PATCH);
        return GN_EXIT_OK;
    }
    return gn_app_command(argc - 1, argv + 1);
}
