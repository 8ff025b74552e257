/* The README's table of methods says what gn_methods says: no more, no less, in the same order. */
#include <setjmp.h>
#include <stdbool.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <cmocka.h>

#include <gnomon/method.h>

/* The next line of the file that is a row of the table, cut into its first two cells. */
static bool next_row(FILE *file, char name[64], char description[256])
{
    char line[512];
    while (fgets(line, sizeof line, file))
        if (sscanf(line, "| `%63[^`]` | %255[^|]", name, description) == 2) {
            size_t length = strlen(description);
            while (length > 0 && description[length - 1] == ' ')
                description[--length] = 0;
            return true;
        }
    return false;
}

static void table_lists_every_method(void **state)
{
    (void)state;
    FILE *file = fopen(GNOMON_SOURCE_DIR "/README.md", "r");
    assert_non_null(file);
    char name[64], description[256];
    for (const gn_method *const *method = gn_methods; *method; method++) {
        if (!next_row(file, name, description))
            fail_msg("README.md has no row for %s", (*method)->name);
        assert_string_equal(name, (*method)->name);
        assert_string_equal(description, (*method)->description);
    }
    if (next_row(file, name, description))
        fail_msg("README.md has %s, gn_methods has not", name);
    fclose(file);
}

static void default_is_named(void **state)
{
    (void)state;
    FILE *file = fopen(GNOMON_SOURCE_DIR "/README.md", "r");
    assert_non_null(file);
    char line[512], name[64] = "";
    while (fgets(line, sizeof line, file))
        if (sscanf(line, "`ray` stands for `%63[^`]`", name) == 1)
            break;
    fclose(file);
    assert_non_null(gn_method_find("ray"));
    assert_string_equal(name, gn_method_find("ray")->name);
}

static void methods_are_found_by_name(void **state)
{
    (void)state;
    for (const gn_method *const *method = gn_methods; *method; method++) {
        assert_ptr_equal(gn_method_find((*method)->name), *method);
        assert_true(strlen((*method)->description) > 0);
    }
    assert_null(gn_method_find("ray-nonsense"));
    assert_null(gn_method_find(""));
    assert_null(gn_method_find(NULL));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(table_lists_every_method),
        cmocka_unit_test(default_is_named),
        cmocka_unit_test(methods_are_found_by_name),
    };
    return cmocka_run_group_tests_name("readme", tests, NULL, NULL);
}
