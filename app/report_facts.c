/* Where a report was made. */
#include <stdio.h>
#include <string.h>
#include <sys/utsname.h>
#include <unistd.h>

#include "report.h"

/* The value of the first line "key : value" of a file, or "". */
static void read_value(const char *path, const char *key, char *value, size_t size)
{
    char line[512];
    value[0] = '\0';
    FILE *file = fopen(path, "r");
    while (file && !*value && fgets(line, sizeof line, file)) {
        char *colon = strchr(line, ':');
        if (strncmp(line, key, strlen(key)) != 0 || !colon)
            continue;
        line[strcspn(line, "\n")] = '\0';
        snprintf(value, size, "%s", colon + 1 + strspn(colon + 1, " \t"));
    }
    if (file)
        fclose(file);
}

cJSON *gn_report_machine(void)
{
    cJSON *json = cJSON_CreateObject();
    char processor[256], memory[64];
    struct utsname system;
    read_value("/proc/cpuinfo", "model name", processor, sizeof processor);
    read_value("/proc/meminfo", "MemTotal", memory, sizeof memory);
    double kilobytes = 0;
    cJSON_AddStringToObject(json, "processor", *processor ? processor : "unknown");
    cJSON_AddNumberToObject(json, "cores", (double)sysconf(_SC_NPROCESSORS_ONLN));
    if (sscanf(memory, "%lf", &kilobytes) == 1)
        cJSON_AddNumberToObject(json, "memory_gb", kilobytes / 1048576);
    if (uname(&system) == 0) {
        char text[512];
        snprintf(text, sizeof text, "%.120s %.120s %.120s", system.sysname, system.release,
                 system.machine);
        cJSON_AddStringToObject(json, "system", text);
    }
    return json;
}
