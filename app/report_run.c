/* Commands of a report as processes: this very program, its output read through pipes. */
#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "report.h"

#define MOST_WORDS 128

/* Text that grows; NULL after memory ran out. */
typedef struct text {
    char *start;
    size_t size;
} text;

static void append(text *t, const char *bytes, size_t count)
{
    char *more = t->start ? realloc(t->start, t->size + count + 1) : NULL;
    if (!more) {
        free(t->start);
        t->start = NULL;
        return;
    }
    memcpy(more + t->size, bytes, count);
    t->start = more;
    t->size += count;
    more[t->size] = '\0';
}

/* {out} in a word becomes out. */
static char *fill_out(const char *word, const char *out)
{
    const char *mark = strstr(word, "{out}");
    const size_t before = mark ? (size_t)(mark - word) : strlen(word);
    char *filled = malloc(strlen(word) + strlen(out) + 1);
    if (filled)
        sprintf(filled, "%.*s%s%s", (int)before, word, mark ? out : "",
                mark ? mark + strlen("{out}") : "");
    return filled;
}

char *gn_report_line(const cJSON *argv, const char *out)
{
    text line = {calloc(1, 1), 0};
    append(&line, "gnomon", 6);
    const cJSON *item;
    cJSON_ArrayForEach(item, argv)
    {
        char *word = fill_out(cJSON_GetStringValue(item), out);
        append(&line, " ", 1);
        const bool plain = word && *word &&
                           strspn(word, "abcdefghijklmnopqrstuvwxyz"
                                        "ABCDEFGHIJKLMNOPQRSTUVWXYZ"
                                        "0123456789-_.,:=/+@%#") == strlen(word);
        if (!plain)
            append(&line, "'", 1);
        for (const char *c = word; c && *c; c++)
            append(&line, *c == '\'' ? "'\\''" : c, *c == '\'' ? 4 : 1);
        if (!plain)
            append(&line, "'", 1);
        free(word);
    }
    return line.start;
}

/* In the child: becomes the command. */
static void become(const gn_app_report *report, const cJSON *argv, const int out[2],
                   const int err[2]) __attribute__((noreturn));
static void become(const gn_app_report *report, const cJSON *argv, const int out[2],
                   const int err[2])
{
    char *words[MOST_WORDS + 1] = {NULL};
    int count = 0;
    const cJSON *item;
    cJSON_ArrayForEach(item, argv)
    {
        words[count] =
            count < MOST_WORDS ? fill_out(cJSON_GetStringValue(item), report->work) : NULL;
        if (!words[count])
            _exit(GN_EXIT_FAILURE);
        count++;
    }
    if (dup2(out[1], STDOUT_FILENO) < 0 || dup2(err[1], STDERR_FILENO) < 0)
        _exit(GN_EXIT_FAILURE);
    for (int i = 0; i < 2; i++) {
        close(out[i]);
        close(err[i]);
    }
    const int code = gn_app_command(count, words);
    fflush(stdout);
    _exit(code);
}

/* Lines on standard error: progress moves the bar, the last of the others may say what is wrong. */
static void read_messages(gn_app *app, text *messages, char said[1024])
{
    char *line = messages->start, *end;
    for (; line && (end = strchr(line, '\n')); line = end + 1) {
        *end = '\0';
        int percent, length = 0;
        if (sscanf(line, "%d %% %n", &percent, &length) == 1 && length > 0)
            gn_bar_update(&app->bar, percent * 0.01);
        else if (!strncmp(line, "gnomon ", 7) && !strstr(line, ": note: "))
            snprintf(said, 1024, "%s", line);
    }
    if (line) {
        messages->size = strlen(line);
        memmove(messages->start, line, messages->size + 1);
    }
}

/* Reads both pipes to their ends. */
static void listen(gn_app *app, pid_t child, int out, int err, text *output, char said[1024])
{
    struct pollfd ends[2] = {{out, POLLIN, 0}, {err, POLLIN, 0}};
    text messages = {calloc(1, 1), 0};
    bool told = false;
    for (int open = 2; open > 0;) {
        poll(ends, 2, 200);
        if (gn_app_interrupted() && !told) {
            kill(child, SIGTERM);
            told = true;
        }
        for (int i = 0; i < 2; i++) {
            char bytes[4096];
            if (ends[i].fd < 0 || !ends[i].revents)
                continue;
            const ssize_t got = read(ends[i].fd, bytes, sizeof bytes);
            if (got > 0) {
                append(i == 0 ? output : &messages, bytes, (size_t)got);
            } else if (got == 0 || errno != EINTR) {
                ends[i].fd = -1;
                open--;
            }
        }
        read_messages(app, &messages, said);
    }
    free(messages.start);
}

/* The pictures will lie in images/, as seen from the page. */
static void rename_folder(char *json, const char *work)
{
    static const char name[] = "images";
    const size_t length = strlen(work);
    for (char *at = json; (at = strstr(at, work));) {
        memcpy(at, name, sizeof name - 1); /* work is longer: it holds a template of its own */
        memmove(at + sizeof name - 1, at + length, strlen(at + length) + 1);
    }
}

static void note_result(gn_app_report *report, cJSON *run, int status, char *output,
                        const char *said)
{
    cJSON *result = NULL;
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0 && output) {
        rename_folder(output, report->work);
        result = cJSON_Parse(output);
    }
    if (result) {
        cJSON_AddItemToObject(run, "result", result);
        return;
    }
    char why[1100];
    if (WIFSIGNALED(status))
        snprintf(why, sizeof why, "ended by signal %d", WTERMSIG(status));
    else
        snprintf(why, sizeof why, "%s", *said ? said : "it printed no result");
    cJSON_AddStringToObject(run, "error", why);
    report->failed++;
}

bool gn_report_run(gn_app_report *report, cJSON *run, double base, double span)
{
    gn_app *app = &report->app;
    const cJSON *argv = cJSON_GetObjectItem(run, "argv");
    char images[4096];
    int out[2] = {-1, -1}, err[2] = {-1, -1};
    snprintf(images, sizeof images, "%.4000s/images", report->folder);
    char *line = gn_report_line(argv, images);
    cJSON_AddStringToObject(run, "line", line ? line : "");
    gn_bar_step(&app->bar, base, span, "%.80s", line ? line : "");
    free(line);

    const double start = gn_milliseconds();
    pid_t child = -1;
    fflush(stdout);
    fflush(stderr);
    if (pipe(out) == 0 && pipe(err) == 0)
        child = fork();
    if (child == 0)
        become(report, argv, out, err);
    const int error = errno;
    for (int i = 0; i < 2; i++) {
        int *const ends[] = {out, err};
        if (ends[i][1] >= 0)
            close(ends[i][1]);
    }
    if (child > 0) {
        text output = {calloc(1, 1), 0};
        char said[1024] = "";
        int status = 0;
        listen(app, child, out[0], err[0], &output, said);
        while (waitpid(child, &status, 0) < 0 && errno == EINTR)
            continue;
        if (!gn_app_interrupted())
            note_result(report, run, status, output.start, said);
        free(output.start);
        cJSON_AddNumberToObject(run, "seconds", (gn_milliseconds() - start) * 1e-3);
    }
    if (out[0] >= 0)
        close(out[0]);
    if (err[0] >= 0)
        close(err[0]);
    if (child < 0)
        return gn_app_error(app, "cannot start a process: %s", strerror(error));
    return !gn_app_interrupted();
}
