/* Running the built program in a folder of its own. */
#ifndef GN_TESTS_CLI_TESTING_H
#define GN_TESTS_CLI_TESTING_H

#include <dirent.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>
#include <cmocka.h>

#include <cjson/cJSON.h>

static char folder[64];
static char out[1 << 16], err[1 << 16];

static inline void read_all(const char *name, char *text, size_t size)
{
    FILE *file = fopen(name, "rb");
    assert_non_null(file);
    text[fread(text, 1, size - 1, file)] = '\0';
    fclose(file);
}

/* Runs the program in the folder; out and err get what it prints. */
static inline int run(const char *arguments)
{
    char command[1024];
    snprintf(command, sizeof command, "%s %s >.out 2>.err", GNOMON_PROGRAM, arguments);
    const int status = system(command);
    read_all(".out", out, sizeof out);
    read_all(".err", err, sizeof err);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

static inline void expect(int code, const char *arguments)
{
    const int got = run(arguments);
    if (got != code)
        fail_msg("'%s' returned %d, not %d; it said: %s", arguments, got, code, err);
}

static inline void expect_text(const char *text, const char *part)
{
    if (!strstr(text, part))
        fail_msg("'%s' is not in: %s", part, text);
}

/* Files that a user would see. */
static inline unsigned count_files(void)
{
    unsigned count = 0;
    DIR *directory = opendir(".");
    assert_non_null(directory);
    for (struct dirent *entry; (entry = readdir(directory));)
        count += entry->d_name[0] != '.';
    closedir(directory);
    return count;
}

static inline bool exists(const char *name)
{
    return access(name, F_OK) == 0;
}

static inline int setup(void **state)
{
    (void)state;
    strcpy(folder, "/tmp/gnomon-cli-XXXXXX");
    return mkdtemp(folder) && chdir(folder) == 0 ? 0 : -1;
}

static inline int teardown(void **state)
{
    (void)state;
    char command[192];
    snprintf(command, sizeof command, "chmod -R u+w %s && rm -r %s", folder, folder);
    return chdir("/") == 0 && system(command) == 0 ? 0 : -1;
}

static inline cJSON *parse_output(void)
{
    cJSON *json = cJSON_Parse(out);
    if (!json)
        fail_msg("not JSON: %s", out);
    return json;
}

static inline double get_number(const cJSON *json, const char *key)
{
    const cJSON *value = cJSON_GetObjectItem(json, key);
    if (!cJSON_IsNumber(value))
        fail_msg("no number '%s'", key);
    return value->valuedouble;
}

static inline const char *get_string(const cJSON *json, const char *key)
{
    const char *value = cJSON_GetStringValue(cJSON_GetObjectItem(json, key));
    if (!value)
        fail_msg("no string '%s'", key);
    return value;
}

static inline const cJSON *member(const cJSON *json, const char *key)
{
    const cJSON *found = cJSON_GetObjectItem(json, key);
    if (!found)
        fail_msg("no '%s'", key);
    return found;
}

/* The entry of a list with that name. */
static inline const cJSON *named(const cJSON *list, const char *name)
{
    const cJSON *entry;
    cJSON_ArrayForEach(entry, list) if (strcmp(get_string(entry, "name"), name) == 0) return entry;
    fail_msg("no '%s'", name);
    return NULL;
}

/* Exactly the bytes of a file. */
static inline bool same_files(const char *a, const char *b)
{
    char command[256];
    snprintf(command, sizeof command, "cmp -s %s %s", a, b);
    return system(command) == 0;
}

/* Starts the program in the folder, its messages in .err. */
static inline pid_t start(const char *arguments)
{
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        char command[1024];
        snprintf(command, sizeof command, "exec %s %s >.out 2>.err", GNOMON_PROGRAM, arguments);
        execl("/bin/sh", "sh", "-c", command, (char *)NULL);
        _exit(99);
    }
    return child;
}

/* Waits until the program minds its signals. */
static inline void wait_for_handler(pid_t child, int number)
{
    char name[64], text[4096];
    snprintf(name, sizeof name, "/proc/%ld/status", (long)child);
    for (int i = 0; i < 6000; i++) {
        read_all(name, text, sizeof text);
        const char *caught = strstr(text, "SigCgt:");
        assert_non_null(caught);
        if (strtoull(caught + 7, NULL, 16) >> (number - 1) & 1)
            return;
        usleep(5000);
    }
    fail();
}

static inline void wait_for_file(const char *name)
{
    for (int i = 0; i < 6000 && !exists(name); i++)
        usleep(5000);
    assert_true(exists(name));
}

/* Waits until a file is there, sends a signal, and waits for the end; the exit code. */
static inline int interrupt(pid_t child, const char *file, int number)
{
    wait_for_file(file);
    wait_for_handler(child, number);
    kill(child, number);
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    read_all(".out", out, sizeof out);
    read_all(".err", err, sizeof err);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

static inline void assert_no_partial_files(void)
{
    assert_int_equal(system("ls -a | grep -q '\\.part$'"), 256); /* grep found none */
}

#endif
