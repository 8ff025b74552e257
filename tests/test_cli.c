/* The built program from outside: exit codes, messages, JSON, files, and nothing left behind. */
#include "cli_testing.h"

/* Small and quick. */
#define SHOT " leafbox --size 48x32 --quiet "

static void test_help(void **state)
{
    (void)state;
    expect(0, "--help");
    expect_text(out, "Usage: gnomon COMMAND");
    expect(0, "--version");
    expect_text(out, "gnomon 0.");
    expect(2, "");
    const char *commands[] = {"render",  "compare",   "bench", "demo",
                              "methods", "histogram", "scene", "info"};
    for (size_t i = 0; i < sizeof commands / sizeof *commands; i++) {
        char arguments[64];
        snprintf(arguments, sizeof arguments, "%s --help", commands[i]);
        expect(0, arguments);
        assert_string_equal(err, "");
        /* Two examples, each a command that can be copied. */
        const char *examples = strstr(out, "Examples:\n");
        assert_non_null(examples);
        unsigned count = 0;
        for (const char *line = examples; (line = strstr(line, "\n  gnomon ")); line++)
            count++;
        assert_int_equal(count, 2);
    }
}

static void test_wrong_usage(void **state)
{
    (void)state;
    static const struct {
        const char *arguments, *message;
    } cases[] = {
        {"rendr", "did you mean 'render'"},
        {"nothing-like-it", "no command 'nothing-like-it'"},
        {"render", "SCENE is missing"},
        {"render leafbox", "-o"},
        {"render leafbox -o a.jpg", "'a.jpg'"},
        {"render leafbox -o a.png --size 12", "'12' is not WIDTHxHEIGHT"},
        {"render leafbox -o a.png --size 0x4", "'0x4'"},
        {"render leafbox -o a.png --spp 0", "'0' is not a whole number from 1 to 4096"},
        {"render leafbox -o a.png --spp", "--spp needs a value"},
        {"render leafbox -o a.png --metod x", "did you mean '--method'"},
        {"render leafbox -o a.png -m ray-satrate", "did you mean 'ray-saturate'"},
        {"render leafbox -o a.png --alpha hard", "one of mip0"},
        {"render leafbox -o a.png --alpha raw -m ray", "exclude each other"},
        {"render leafbox -o a.png --frames 5:2", "'5:2' is not FIRST:LAST"},
        {"render leafbox -o a.png --sun 10,99", "'10,99' is not AZIMUTH,ELEVATION"},
        {"render leafbox -o a.png --aov depht", "no 'depht'"},
        {"render leafbox -o a.png --time nan", "'nan' is not a number"},
        {"render leafbox -o a.png --quiet=1", "--quiet takes no value"},
        {"render leafbox court -o a.png", "'court' is one argument too many"},
        {"render" SHOT "-o a.png --light Lamp --sun 0,45", "exclude each other"},
        {"compare leafbox --a ray", "--b METHOD is missing"},
        {"compare leafbox --a ray,ray-raw --b ray", "--a takes one method"},
        {"scene grov -o a.glb", "did you mean 'grove'"},
        {"scene grove", "-o OUT.glb is missing"},
        {"demo", "-o FOLDER is missing"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        expect(2, cases[i].arguments);
        expect_text(err, cases[i].message);
        assert_string_equal(out, "");
    }
    assert_int_equal(count_files(), 0);
}

static void test_failures(void **state)
{
    (void)state;
    assert_int_equal(symlink("/dev/full", "full.png"), 0);
    assert_int_equal(symlink("/dev/full", "full.exr"), 0);
    assert_int_equal(symlink("/dev/full", "full.glb"), 0);
    assert_int_equal(mkdir("folder.png", 0777), 0);
    static const struct {
        const char *arguments, *message;
    } cases[] = {
        {"render missing.glb -o a.png", "missing.glb"},
        {"info /", "/"},
        {"render" SHOT "-o nowhere/a.png", "nowhere/a.png: cannot write: No such file"},
        {"render" SHOT "-o full.png", "full.png: cannot write: No space left"},
        {"render" SHOT "-o full.exr", "full.exr: cannot write: No space left"},
        {"scene leafbox -q -o full.glb", "No space left"},
        {"render" SHOT "-o folder.png", "folder.png: cannot write: Is a directory"},
        {"render" SHOT "-o a.png --camera Nix", "no camera 'Nix'; it has: CamFront"},
        {"render" SHOT "-o a.png --light Nix", "no light 'Nix'; it has: Lamp"},
        {"compare" SHOT "--a ray --b ray-raw -o full.exr", "full.exr: cannot make the folder"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        expect(1, cases[i].arguments);
        expect_text(err, cases[i].message);
    }
    assert_int_equal(count_files(), 4);
    /* Standard output may be full too. */
    static const char *const printing[] = {"info leafbox", "info leafbox --json", "scene --list",
                                           "render" SHOT "-o a.png --json"};
    for (size_t i = 0; i < sizeof printing / sizeof *printing; i++) {
        char command[512];
        snprintf(command, sizeof command, "%s %s >/dev/full 2>.err", GNOMON_PROGRAM, printing[i]);
        const int status = system(command);
        read_all(".err", err, sizeof err);
        if (!WIFEXITED(status) || WEXITSTATUS(status) != 1)
            fail_msg("'%s' ended with %d on a full disk", printing[i], status);
        expect_text(err, "standard output: cannot write");
    }
}

static void test_render(void **state)
{
    (void)state;
    expect(0, "render" SHOT "-o a.png --aov visibility,depth,normal,shading_normal,albedo,motion,"
              "position,lod,lookups --json");
    cJSON *json = parse_output();
    assert_string_equal(get_string(json, "command"), "render");
    assert_string_equal(get_string(json, "scene"), "leafbox");
    assert_string_equal(get_string(json, "camera"), "CamFront");
    assert_int_equal((int)get_number(json, "width"), 48);
    const cJSON *frame = cJSON_GetArrayItem(cJSON_GetObjectItem(json, "frames"), 0);
    const double mean =
        cJSON_GetArrayItem(cJSON_GetObjectItem(frame, "mean_visibility"), 0)->valuedouble;
    if (!(mean > 0.1 && mean < 0.95))
        fail_msg("mean visibility %g: no shadow, or nothing else", mean);
    assert_true(get_number(cJSON_GetObjectItem(frame, "ms"), "visibility") > 0);
    const cJSON *files = cJSON_GetObjectItem(frame, "files"), *file;
    assert_int_equal(cJSON_GetArraySize(files), 10);
    cJSON_ArrayForEach(file, files) assert_true(exists(file->valuestring));
    cJSON_Delete(json);
    assert_int_equal(count_files(), 10);
    assert_string_equal(err, "");
}

static void test_sequences(void **state)
{
    (void)state;
    expect(0, "render" SHOT "-o a.###.png --frames 8:9");
    assert_true(exists("a.008.png") && exists("a.009.png"));
    expect(0, "render" SHOT "-o b-%02d.exr --frames 1:1");
    assert_true(exists("b-01.exr"));
    expect(0, "render" SHOT "-o c.png --frames 0:0 --aov visibility");
    assert_true(exists("c.0000.png") && exists("c.0000.visibility.png"));
    assert_int_equal(count_files(), 5);
}

static void test_same_bytes(void **state)
{
    (void)state;
    expect(0, "render" SHOT "-o a.exr --threads 1");
    expect(0, "render" SHOT "-o b.exr --threads 2");
    expect(0, "render" SHOT "-o c.exr -m ray-mip0");
    assert_true(same_files("a.exr", "b.exr"));
    assert_false(same_files("a.exr", "c.exr"));
    /* --alpha is the method of that rule. */
    expect(0, "render" SHOT "-o d.exr --alpha mip0");
    assert_true(same_files("c.exr", "d.exr"));
    /* A moved sun, time and camera change the picture. */
    expect(0, "render" SHOT "-o e.exr --sun 100,40");
    expect(0, "render" SHOT "-o f.exr --sun 190,40");
    assert_false(same_files("e.exr", "f.exr"));
    expect(0, "render" SHOT "-o g.exr --camera CamOrbit");
    expect(0, "render" SHOT "-o h.exr --camera CamOrbit --time 1.5");
    assert_false(same_files("g.exr", "h.exr"));
}

static void test_compare(void **state)
{
    (void)state;
    expect(0, "compare" SHOT "--a ray-mip0 --b ray-coverage -o d --json");
    cJSON *json = parse_output();
    const cJSON *first = cJSON_GetArrayItem(cJSON_GetObjectItem(json, "differences"), 0);
    assert_true(get_number(first, "mse") > 0);
    assert_true(get_number(first, "mse") <= get_number(first, "mean_abs"));
    assert_true(get_number(json, "time_ratio") > 0);
    assert_int_equal((int)get_number(cJSON_GetObjectItem(json, "a"), "runs"), 5);
    cJSON_Delete(json);
    assert_true(exists("d/a.png") && exists("d/b.png") && exists("d/difference.png") &&
                exists("d/side-by-side.png"));

    /* A method does not differ from itself. */
    expect(0, "compare" SHOT "--a ray-raw --b ray-raw --json");
    json = parse_output();
    first = cJSON_GetArrayItem(cJSON_GetObjectItem(json, "differences"), 0);
    assert_true(get_number(first, "max_abs") == 0);
    assert_true(cJSON_IsNull(cJSON_GetObjectItem(first, "psnr")));
    cJSON_Delete(json);
    expect(0, "compare" SHOT "--a reference --b ray-raw -o s.png");
    assert_true(exists("s.png"));
    assert_int_equal(count_files(), 2);
}

static void test_scene_and_info(void **state)
{
    (void)state;
    expect(0, "scene --list --json");
    cJSON *json = parse_output();
    assert_int_equal(cJSON_GetArraySize(cJSON_GetObjectItem(json, "scenes")), 5);
    cJSON_Delete(json);

    expect(0, "scene leafbox -o leafbox --seed 5 -q");
    expect(0, "info leafbox --seed 99 --json"); /* a file wins over a built-in name */
    cJSON *from_file = parse_output();
    assert_int_equal(unlink("leafbox"), 0);
    expect(0, "info leafbox --seed 5 --json");
    cJSON *built_in = parse_output();
    const char *keys[] = {
        "triangles", "instanced_triangles", "masked_triangles", "cameras", "lights", "duration"};
    for (size_t i = 0; i < sizeof keys / sizeof *keys; i++) {
        if (get_number(from_file, keys[i]) != get_number(built_in, keys[i]))
            fail_msg("%s: %g in the file, %g built in", keys[i], get_number(from_file, keys[i]),
                     get_number(built_in, keys[i]));
    }
    cJSON_Delete(from_file);
    cJSON_Delete(built_in);
    expect(0, "info leafbox");
    expect_text(out, "CamFront");
    expect_text(out, "Lamp");
}

/* A scene of one triangle, without lights and cameras. */
static void test_defaults(void **state)
{
    (void)state;
    FILE *file = fopen("triangle.gltf", "wb");
    assert_non_null(file);
    fputs("{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"
          "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":{"
          "\"POSITION\":0}}]}],\"buffers\":[{\"byteLength\":36,\"uri\":\"data:application/"
          "octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA\"}],"
          "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],\"accessors\":[{\"bufferView\":0,"
          "\"componentType\":5126,\"count\":3,\"type\":\"VEC3\",\"min\":[0,0,0],"
          "\"max\":[1,1,0]}]}",
          file);
    fclose(file);
    expect(0, "render triangle.gltf --size 48x32 -o a.png");
    expect_text(err, "note: triangle.gltf has no camera");
    expect_text(err, "note: triangle.gltf has no light");
    expect(0, "render triangle.gltf --size 48x32 -o a.png --quiet");
    assert_string_equal(err, "");
    expect(1, "render triangle.gltf --size 48x32 -o b.png --camera Main");
    expect_text(err, "no cameras");
    assert_int_equal(count_files(), 2);
}

static void test_interrupt(void **state)
{
    (void)state;
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        if (!freopen(".err", "wb", stderr))
            _exit(99);
        execl(GNOMON_PROGRAM, "gnomon", "render", "leafbox", "--size", "64x48", "-o", "a.png",
              "--frames", "0:9999", (char *)NULL);
        _exit(99);
    }
    /* Stop it in the middle of a sequence. */
    for (int i = 0; i < 3000 && !exists("a.0002.png"); i++)
        usleep(10000);
    kill(child, SIGINT);
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFEXITED(status));
    assert_int_equal(WEXITSTATUS(status), 130);
    read_all(".err", err, sizeof err);
    expect_text(err, "are finished");
    expect_text(err, "interrupted");
    assert_true(exists("a.0002.png"));
    assert_int_equal(system("ls | grep -q part"), 256); /* grep found none */
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_help, setup, teardown),
        cmocka_unit_test_setup_teardown(test_wrong_usage, setup, teardown),
        cmocka_unit_test_setup_teardown(test_failures, setup, teardown),
        cmocka_unit_test_setup_teardown(test_render, setup, teardown),
        cmocka_unit_test_setup_teardown(test_sequences, setup, teardown),
        cmocka_unit_test_setup_teardown(test_same_bytes, setup, teardown),
        cmocka_unit_test_setup_teardown(test_compare, setup, teardown),
        cmocka_unit_test_setup_teardown(test_scene_and_info, setup, teardown),
        cmocka_unit_test_setup_teardown(test_defaults, setup, teardown),
        cmocka_unit_test_setup_teardown(test_interrupt, setup, teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
