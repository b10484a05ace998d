/* Pictures and players: what is in the file is what the particles are. */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <cairo.h>
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "driftlab/picture.h"
#include "report/base64.h"
#include "report/html_text.h"
#include "report/picture_look.h"
#include "report/player_data.h"

/* Four particles in a box, one of them pinned. The title must not become markup. */
static const char scene_text[] = "name: \"four <b> & more\"\n"
                                 "dimension: 2\n"
                                 "particles:\n"
                                 "  - {at: [1, 1], velocity: [30, 0], mass: 2000}\n"
                                 "  - {at: [3, 1], velocity: [0, 40], mass: 10000}\n"
                                 "  - {at: [1, 3], velocity: [-150, -150], mass: 4000}\n"
                                 "  - {at: [3, 3], mass: 6000, pinned: true}\n"
                                 "pair_law:\n"
                                 "  - {until: 2, terms: [{coefficient: 1.0e-9, power: 2}]}\n"
                                 "walls: {x: [0, 4], y: [0, none], damping: 0, rule: mirror}\n"
                                 "time: {step: 1.0e-3, end: 0.01}\n";

enum { particles = 4, frames_written = 11, steps_apart = 5 };

static char folder[] = "/tmp/driftlab-picture-XXXXXX";
static char scene_path[64], trajectory_path[64], out_path[64];
static dl_scene *scene;

static void assert_near(double found, double expected, double within) {
    if (!(fabs(found - expected) <= within))
        fail_msg("found %.17g, expected %.17g to %.3g", found, expected, within);
}

/* --- fixture ---------------------------------------------------------------------------------- */

/* Particle 0 moves along x, particle 1 along y; the others stay. */
static void state_at(size_t frame, double *y_all) {
    const double t = (double)frame;
    memcpy(y_all, scene->position, 2 * particles * sizeof *y_all);
    memcpy(y_all + 2 * particles, scene->velocity, 2 * particles * sizeof *y_all);
    y_all[0] += 0.05 * t;
    y_all[particles + 1] += 0.07 * t;
}

static void write_trajectory(void) {
    dl_error error = {""};
    dl_trajectory *trajectory = NULL;
    double y_all[4 * particles];
    assert_int_equal(
        dl_trajectory_create(trajectory_path, scene, "leapfrog", "step=0.001", &trajectory, &error),
        DL_OK);
    for (size_t k = 0; k < frames_written; k++) {
        state_at(k, y_all);
        const dl_sample sample = {.index = k,
                                  .step = steps_apart * k,
                                  .time = 1e-3 * steps_apart * (double)k,
                                  .energy = {1, 0, 0, 1},
                                  .energy_error = 1e-6 * (double)k,
                                  .y_all = y_all};
        assert_int_equal(dl_trajectory_append(trajectory, &sample, &error), DL_OK);
    }
    assert_int_equal(dl_trajectory_close(trajectory, &error), DL_OK);
}

static int prepare(void **state) {
    (void)state;
    dl_error error = {""};
    if (!mkdtemp(folder))
        return -1;
    snprintf(scene_path, sizeof scene_path, "%s/scene.yaml", folder);
    snprintf(trajectory_path, sizeof trajectory_path, "%s/run.h5", folder);
    snprintf(out_path, sizeof out_path, "%s/out.svg", folder);
    FILE *const file = fopen(scene_path, "w");
    if (!file || fputs(scene_text, file) < 0 || fclose(file))
        return -1;
    if (dl_scene_read(scene_path, &scene, &error))
        fail_msg("%s", error.message);
    write_trajectory();
    return 0;
}

static int clean(void **state) {
    (void)state;
    dl_scene_free(scene);
    unlink(scene_path);
    unlink(trajectory_path);
    return rmdir(folder);
}

static char *read_and_remove(const char *path) {
    FILE *const file = fopen(path, "rb");
    assert_non_null(file);
    fseek(file, 0, SEEK_END);
    const size_t size = (size_t)ftell(file);
    rewind(file);
    char *const content = calloc(size + 1, 1);
    assert_non_null(content);
    assert_int_equal(fread(content, 1, size, file), size);
    fclose(file);
    unlink(path);
    return content;
}

static dl_picture picture_of(double *y_all) {
    state_at(0, y_all);
    return (dl_picture){.scene = scene, .y_all = y_all, .up = 1};
}

static char *draw(const dl_picture *picture) {
    dl_error error = {""};
    if (dl_picture_write(picture, out_path, &error))
        fail_msg("%s", error.message);
    return read_and_remove(out_path);
}

/* What stands between the axes: the legend holds circles, too. */
static char *plot_of(char *svg) {
    char *const from = strstr(svg, "<g class=\"plot\"");
    assert_non_null(from);
    char *const to = strstr(from, "</g>");
    assert_non_null(to);
    *to = '\0';
    return from;
}

static size_t occurrences(const char *text, const char *what) {
    size_t found = 0;
    for (const char *at = text; (at = strstr(at, what)); at += strlen(what))
        found++;
    return found;
}

typedef struct circle {
    double x, y, radius;
    unsigned fill;
} circle;

/* The circles of the plot, by decreasing mass: that is the order they are drawn in. */
static size_t circles_of(const char *plot, circle *found, size_t room) {
    size_t count = 0;
    for (const char *at = plot; (at = strstr(at, "<circle ")) && count < room; at++) {
        circle *const one = &found[count];
        if (sscanf(at, "<circle cx=\"%lf\" cy=\"%lf\" r=\"%lf\" class=\"particle\" fill=\"#%x\"",
                   &one->x, &one->y, &one->radius, &one->fill) == 4)
            count++;
    }
    return count;
}

/* --- pictures --------------------------------------------------------------------------------- */

static void a_circle_a_particle_sized_and_shaded_by_mass(void **state) {
    (void)state;
    double y_all[4 * particles];
    const dl_picture picture = picture_of(y_all);
    char *const svg = draw(&picture);
    assert_null(strstr(svg, "<b>"));
    assert_non_null(strstr(svg, "four &lt;b&gt; &amp; more"));
    assert_non_null(strstr(svg, "mass 10000 (1)"));
    assert_non_null(strstr(svg, "x [length]"));
    circle found[particles + 1];
    const char *const plot = plot_of(svg);
    assert_int_equal(circles_of(plot, found, particles + 1), particles);
    for (size_t k = 1; k < particles; k++) {
        assert_true(found[k].radius < found[k - 1].radius);
        assert_true(found[k].fill > found[k - 1].fill);
    }
    assert_int_equal(found[particles - 1].fill, 0xffffff);
    /* Areas are as the masses. */
    assert_near(pow(found[0].radius / found[3].radius, 2), 5, 0.05);
    /* Equal axes: 10000 at (3, 1), 6000 at (3, 3), 2000 at (1, 1). */
    assert_near(found[0].x, found[1].x, 0.02);
    assert_near(found[0].y - found[1].y, found[0].x - found[3].x, 0.02);
    assert_true(found[0].y > found[1].y);
    assert_int_equal(occurrences(plot, "class=\"wall\""), 3);
    assert_int_equal(occurrences(plot, "class=\"pinned\""), 2); /* one cross */
    free(svg);
}

static void sizes_span_little_whatever_the_masses(void **state) {
    (void)state;
    double mass[3] = {1, 100, 1e6};
    size_t number[3] = {1, 1, 1};
    const dl_masses masses = {3, mass, number};
    assert_near(dl_size_of(&masses, 1e6), 1, 1e-12);
    assert_near(dl_size_of(&masses, 1), 1 / 2.5, 1e-12);
    assert_true(dl_size_of(&masses, 100) > dl_size_of(&masses, 1));
    assert_int_equal(dl_shade_of(&masses, 1), 0xffffff);
}

static void equal_size_is_equal(void **state) {
    (void)state;
    double y_all[4 * particles];
    dl_picture picture = picture_of(y_all);
    picture.equal_size = true;
    picture.colour = DL_COLOUR_NONE;
    char *const svg = draw(&picture);
    circle found[particles];
    assert_int_equal(circles_of(plot_of(svg), found, particles), particles);
    for (size_t k = 0; k < particles; k++) {
        assert_near(found[k].radius, found[0].radius, 1e-9);
        assert_int_equal(found[k].fill, 0xffffff);
    }
    free(svg);
}

static void states_stand_in_hexagons_and_triangles(void **state) {
    (void)state;
    static const dl_state states[particles] = {DL_SOLID, DL_LIQUID, DL_GAS, DL_SOLID};
    double y_all[4 * particles];
    dl_picture picture = picture_of(y_all);
    picture.colour = DL_COLOUR_STATE;
    picture.state = states;
    char *const svg = draw(&picture);
    assert_non_null(strstr(svg, "solid (2)"));
    const char *const plot = plot_of(svg);
    assert_int_equal(occurrences(plot, "class=\"particle\""), particles);
    assert_int_equal(occurrences(plot, "class=\"solid\""), 2);
    assert_int_equal(occurrences(plot, "class=\"gas\""), 1);
    assert_int_equal(occurrences(plot, "class=\"liquid\""), 0);
    double x[7], y[7];
    const char *const gas = strstr(plot, "class=\"gas\"");
    const char *from = gas;
    while (*from != '<')
        from--;
    assert_int_equal(sscanf(from, "<polygon points=\"%lf,%lf %lf,%lf %lf,%lf %lf,%lf", &x[0], &y[0],
                            &x[1], &y[1], &x[2], &y[2], &x[3], &y[3]),
                     6); /* three corners and no fourth */
    free(svg);
}

static void arrows_point_where_particles_go(void **state) {
    (void)state;
    double y_all[4 * particles];
    dl_picture picture = picture_of(y_all);
    picture.velocities = true;
    char *const svg = draw(&picture);
    const char *at = plot_of(svg);
    circle found[particles];
    assert_int_equal(circles_of(at, found, particles), particles);
    /* Right, up, down to the left; the pinned one has none. */
    static const double direction[][2] = {{30, 0}, {0, -40}, {-150, 150}};
    for (size_t k = 0; k < 3; k++) {
        double x0, y0, x1, y1, tip_x, tip_y;
        at = strstr(at, "<polyline points=\"");
        while (at && !(strstr(at, "class=\"velocity\"") < strchr(at, '>')))
            at = strstr(at + 1, "<polyline points=\"");
        assert_non_null(at);
        assert_int_equal(sscanf(at, "<polyline points=\"%lf,%lf %lf,%lf\"", &x0, &y0, &x1, &y1), 4);
        at = strstr(at, "<polygon points=\"");
        assert_int_equal(sscanf(at, "<polygon points=\"%lf,%lf", &tip_x, &tip_y), 2);
        const double *const d = direction[k], length = hypot(d[0], d[1]);
        const double drawn = hypot(tip_x - x0, tip_y - y0);
        assert_true(drawn > 1.5);
        assert_near((tip_x - x0) / drawn, d[0] / length, 0.02);
        assert_near((tip_y - y0) / drawn, d[1] / length, 0.02);
    }
    assert_null(strstr(at, "class=\"velocity\""));
    free(svg);
}

static void colours_tell_speeds(void **state) {
    (void)state;
    double y_all[4 * particles];
    dl_picture picture = picture_of(y_all);
    picture.colour = DL_COLOUR_SPEED;
    char *const svg = draw(&picture);
    assert_non_null(strstr(svg, "speed 0 to "));
    circle found[particles];
    assert_int_equal(circles_of(plot_of(svg), found, particles), particles);
    assert_int_equal(found[1].fill, dl_colour_of(0)); /* the pinned one */
    assert_int_equal(found[2].fill, dl_colour_of(1));
    free(svg);
    double uniform[3] = {99, 100, 98}, rest[2] = {0, 0}, runaway[100];
    assert_near(dl_speed_range_of(uniform, 3).low, 98, 0); /* a stream */
    assert_near(dl_speed_range_of(rest, 2).high, 0, 0);
    for (size_t k = 0; k < 100; k++)
        runaway[k] = k ? 1 : 1000;
    const dl_speed_range range = dl_speed_range_of(runaway, 100);
    assert_near(range.high, 1, 0);
    assert_true(range.has_faster);
}

static void a_window_leaves_out_and_says_so(void **state) {
    (void)state;
    double y_all[4 * particles];
    dl_picture picture = picture_of(y_all);
    const dl_picture_window window = {{0, 0}, {2, 4}};
    picture.window = &window;
    char *const svg = draw(&picture);
    assert_non_null(strstr(svg, "2 outside the picture"));
    circle found[particles];
    assert_int_equal(circles_of(plot_of(svg), found, particles), 2);
    free(svg);
}

/* One between whose ends there are no numbers to tell positions by is refused, not drawn for ever.
 */
static void a_window_has_a_width(void **state) {
    (void)state;
    double y_all[4 * particles];
    dl_picture picture = picture_of(y_all);
    const dl_picture_window narrow[] = {
        {{0, 1e16}, {4, 1e16 + 4}}, {{1 - 1e-13, 0}, {1, 4}}, {{1, 0}, {1, 4}}};
    picture.window = &narrow[0];
    for (size_t k = 0; k < sizeof narrow / sizeof *narrow; k++) {
        dl_error error = {""};
        picture.window = &narrow[k];
        assert_int_equal(dl_picture_write(&picture, out_path, &error), DL_INPUT);
        assert_non_null(strstr(error.message, "wider than 1e-12"));
        assert_int_not_equal(access(out_path, F_OK), 0);
    }
    const dl_picture_window far = {{1e9, 1}, {1e9 + 1, 2}};
    picture.window = &far;
    free(draw(&picture));
}

/* Particle 0 is farther along every axis than particle 1: which of them hides the other depends on
 * whence one looks. */
static void the_nearer_is_drawn_last(void **state) {
    (void)state;
    static const struct {
        int across, up;
        unsigned last; /* fill of what is drawn last */
    } planes[] = {{0, 1, 0xffffff}, {1, 2, 0xffffff}, {0, 2, 0}};
    dl_scene deep = *scene;
    double y_all[12] = {1, 0, 1, 0, 1, 0}, mass[2] = {1, 2};
    bool pinned[2] = {false, false};
    deep.dimension = 3;
    deep.particles = 2;
    deep.inertia = mass;
    deep.pinned = pinned;
    deep.walls.present = false;
    for (size_t k = 0; k < sizeof planes / sizeof *planes; k++) {
        const dl_picture picture = {
            .scene = &deep, .y_all = y_all, .across = planes[k].across, .up = planes[k].up};
        char *const svg = draw(&picture);
        circle found[2];
        assert_int_equal(circles_of(plot_of(svg), found, 2), 2);
        assert_int_equal(found[1].fill == 0xffffff, planes[k].last == 0xffffff);
        free(svg);
    }
}

static void a_system_leaves_out_what_has_escaped(void **state) {
    (void)state;
    double y_all[4 * particles];
    dl_picture picture = picture_of(y_all);
    dl_error error = {""};
    dl_picture_window window;
    y_all[2] = -90; /* the third has gone where it flies */
    y_all[particles + 2] = -90;
    y_all[1] = 2.5; /* the others hold together */
    y_all[particles + 1] = 1.5;
    assert_int_equal(dl_picture_window_of_system(&picture, &window, &error), DL_OK);
    assert_true(window.low[1] > -2 && window.high[1] < 6);
}

static void periodic_directions_are_drawn_in_the_box(void **state) {
    (void)state;
    double y_all[4 * particles];
    const dl_picture picture = picture_of(y_all);
    scene->periods = (dl_periods){.present = true, .low = {0, 0}, .length = {4, 0}};
    char *const there = draw(&picture);
    y_all[0] += 12;
    y_all[1] -= 4;
    char *const wrapped = draw(&picture);
    scene->periods = (dl_periods){0};
    char *const plot = plot_of(wrapped);
    assert_int_equal(occurrences(plot, "class=\"box\""), 2);
    assert_string_equal(plot, plot_of(there));
    free(there);
    free(wrapped);
}

static void png_has_ink_where_the_particles_are(void **state) {
    (void)state;
    double y_all[4 * particles];
    const dl_picture picture = picture_of(y_all);
    char *const svg = draw(&picture);
    circle found[particles];
    assert_int_equal(circles_of(plot_of(svg), found, particles), particles);
    char path[80];
    dl_error error = {""};
    snprintf(path, sizeof path, "%s/out.png", folder);
    assert_int_equal(dl_picture_write(&picture, path, &error), DL_OK);
    cairo_surface_t *const image = cairo_image_surface_create_from_png(path);
    assert_int_equal(cairo_surface_status(image), CAIRO_STATUS_SUCCESS);
    const unsigned char *const data = cairo_image_surface_get_data(image);
    const int stride = cairo_image_surface_get_stride(image);
    for (size_t k = 0; k < particles; k++) {
        /* Above the middle: a cross may be in it. */
        const int x = (int)lround(2 * found[k].x), y = (int)lround(2 * found[k].y);
        const int rim = (int)lround(2 * (found[k].y - found[k].radius));
        const int inside = y - (int)lround(1.5 * found[k].radius);
        assert_int_equal(data[inside * stride + 4 * x], found[k].fill & 255);
        assert_true(data[rim * stride + 4 * x] < 150);
    }
    cairo_surface_destroy(image);
    unlink(path);
    free(svg);
}

static void a_name_that_is_no_pictures_is_refused(void **state) {
    (void)state;
    double y_all[4 * particles];
    const dl_picture picture = picture_of(y_all);
    dl_error error = {""};
    assert_int_equal(dl_picture_write(&picture, "/tmp/picture.gif", &error), DL_INPUT);
    assert_non_null(strstr(error.message, ".svg or .png"));
    assert_int_equal(dl_picture_write(&picture, "/nowhere/picture.png", &error), DL_IO);
    assert_int_equal(dl_picture_write(&picture, "/nowhere/picture.svg", &error), DL_IO);
}

/* --- frames ----------------------------------------------------------------------------------- */

static void every_frame_is_read(void **state) {
    (void)state;
    dl_frames *frames = NULL;
    dl_error error = {""};
    double expected[4 * particles], read[4 * particles];
    assert_true(dl_file_is_hdf5(trajectory_path));
    assert_false(dl_file_is_hdf5(scene_path));
    assert_false(dl_file_is_hdf5("/nowhere"));
    assert_int_equal(dl_frames_open(trajectory_path, &frames, &error), DL_OK);
    assert_int_equal(frames->count, frames_written);
    assert_int_equal(frames->particles, particles);
    assert_string_equal(frames->method, "leapfrog");
    assert_string_equal(frames->options, "step=0.001");
    for (size_t k = frames_written; k-- > 0;) {
        state_at(k, expected);
        assert_int_equal(dl_frames_read(frames, k, 2, read, &error), DL_OK);
        assert_memory_equal(read, expected, sizeof expected);
        assert_int_equal(frames->step[k], steps_apart * k);
        assert_near(frames->energy_error[k], 1e-6 * (double)k, 0);
    }
    assert_int_equal(dl_frames_read(frames, frames_written, 2, read, &error), DL_INPUT);
    dl_frames_close(frames);
    assert_int_equal(dl_frames_open(scene_path, &frames, &error), DL_INPUT);
    assert_null(frames);
}

static void frames_are_found_by_step_and_time(void **state) {
    (void)state;
    dl_frames *frames = NULL;
    dl_error error = {""};
    size_t number = 99;
    assert_int_equal(dl_frames_open(trajectory_path, &frames, &error), DL_OK);
    assert_int_equal(dl_frames_at_step(frames, 35, &number, &error), DL_OK);
    assert_int_equal(number, 7);
    assert_int_equal(dl_frames_at_time(frames, 0.035, &number, &error), DL_OK);
    assert_int_equal(number, 7);
    assert_int_equal(dl_frames_at_step(frames, 36, &number, &error), DL_INPUT);
    assert_non_null(strstr(error.message, "0 to 50, every 5"));
    assert_int_equal(dl_frames_at_time(frames, 0.0351, &number, &error), DL_INPUT);
    assert_non_null(strstr(error.message, "0.035 (step 35) and 0.04 (step 40)"));
    dl_frames_close(frames);
}

static void states_follow_the_temperature(void **state) {
    (void)state;
    dl_frames *frames = NULL;
    dl_error error = {""};
    dl_state states[particles];
    assert_int_equal(dl_frames_open(trajectory_path, &frames, &error), DL_OK);
    assert_int_equal(dl_picture_states(scene, frames, 10, states, &error), DL_OK);
    assert_int_equal(states[2], DL_GAS);
    assert_int_equal(states[3], DL_SOLID);
    dl_frames_close(frames);
    double y_all[4 * particles];
    state_at(0, y_all);
    assert_int_equal(dl_picture_states_now(scene, y_all, states, &error), DL_OK);
    assert_int_equal(states[2], DL_GAS);
    scene->inertia[0] = 1;
    assert_int_equal(dl_picture_states_now(scene, y_all, states, &error), DL_INPUT);
    scene->inertia[0] = 2000;
}

/* --- players ---------------------------------------------------------------------------------- */

/* XML has no control characters but these, not even as entities. */
static void text_in_xml_is_what_xml_allows(void **state) {
    (void)state;
    char *const text = dl_html_text("a\x01<b>\t\x1b[1m\n\x1f\"\xc3\xa9");
    assert_string_equal(text, "a&lt;b&gt;\t[1m\n&quot;\xc3\xa9");
    free(text);
}

static void base64_is_rfc_4648(void **state) {
    (void)state;
    static const char *const vector[][2] = {
        {"", ""}, {"f", "Zg=="}, {"fo", "Zm8="}, {"foo", "Zm9v"}, {"foobar", "Zm9vYmFy"}};
    for (size_t k = 0; k < sizeof vector / sizeof *vector; k++) {
        char *const text = dl_base64((const unsigned char *)vector[k][0], strlen(vector[k][0]));
        assert_string_equal(text, vector[k][1]);
        free(text);
    }
}

/* Inverse of dl_base64, by trial of every digit. */
static unsigned char *bytes_of(const char *text) {
    static const char digit[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    const size_t length = strlen(text);
    unsigned char *const bytes = calloc(length, 1);
    size_t count = 0;
    unsigned group = 0;
    assert_non_null(bytes);
    for (size_t k = 0; k < length; k++) {
        const char *const found = text[k] == '=' ? digit : strchr(digit, text[k]);
        assert_non_null(found);
        group = group << 6 | (unsigned)(found - digit);
        if (k % 4 == 3)
            for (int shift = 16; shift >= 0; shift -= 8)
                bytes[count++] = (unsigned char)(group >> shift);
    }
    return bytes;
}

static double real_at(const json_t *array, size_t k) {
    return json_number_value(json_array_get(array, k));
}

static json_t *player_of(size_t bytes) {
    char *text = NULL;
    dl_error error = {""};
    if (dl_player_data(trajectory_path, bytes, &text, &error))
        fail_msg("%s", error.message);
    assert_null(strchr(text, '<'));
    json_t *const data = json_loads(text, 0, NULL);
    free(text);
    assert_non_null(data);
    return data;
}

static void a_player_holds_every_frame_to_its_quantum(void **state) {
    (void)state;
    json_t *const data = player_of(DL_PLAYER_BYTES);
    assert_int_equal(json_array_size(json_object_get(data, "time")), frames_written);
    unsigned char *const position = bytes_of(json_string_value(json_object_get(data, "position")));
    unsigned char *const velocity = bytes_of(json_string_value(json_object_get(data, "velocity")));
    unsigned char *const states = bytes_of(json_string_value(json_object_get(data, "state")));
    const double fastest = json_number_value(json_object_get(data, "fastest"));
    for (size_t frame = 0; frame < frames_written; frame++) {
        double y_all[4 * particles];
        state_at(frame, y_all);
        for (size_t k = 0; k < 2 * particles; k++) {
            const size_t at = 2 * (frame * 2 * particles + k);
            const double low = real_at(json_object_get(data, "low"), k / particles);
            const double high = real_at(json_object_get(data, "high"), k / particles);
            const double unit = (high - low) / 65535;
            assert_near(low + unit * (position[at] | position[at + 1] << 8), y_all[k], 0.51 * unit);
            const int16_t v = (int16_t)(velocity[at] | velocity[at + 1] << 8);
            assert_near(fastest / 32767 * v, y_all[2 * particles + k], 0.51 * fastest / 32767);
        }
        assert_int_equal(states[frame * particles + 2], DL_GAS);
    }
    const json_t *const window = json_object_get(data, "window");
    assert_true(real_at(json_array_get(window, 0), 0) < 0); /* walls at 0 and 4 */
    assert_true(real_at(json_array_get(window, 0), 1) > 4);
    assert_true(json_is_null(json_array_get(json_array_get(json_object_get(data, "walls"), 1), 1)));
    assert_int_equal(json_integer_value(json_array_get(json_object_get(data, "pinned"), 0)), 3);
    free(position);
    free(velocity);
    free(states);
    json_decref(data);
}

static void a_player_that_would_be_too_large_is_thinned(void **state) {
    (void)state;
    json_t *const data = player_of(6 * particles * 9);
    const json_t *const step = json_object_get(data, "step");
    assert_int_equal(json_integer_value(json_object_get(data, "stride")), 3);
    assert_int_equal(json_array_size(step), 5); /* frames 0, 3, 6, 9 and the last */
    assert_int_equal(json_integer_value(json_array_get(step, 1)), 3 * steps_apart);
    assert_int_equal(json_integer_value(json_array_get(step, 4)), 10 * steps_apart);
    json_decref(data);
}

static void a_page_of_players_fetches_nothing(void **state) {
    (void)state;
    char path[80];
    dl_error error = {""};
    const char *const files[] = {trajectory_path, trajectory_path};
    snprintf(path, sizeof path, "%s/player.html", folder);
    assert_int_equal(dl_player_write(files, 2, path, &error), DL_OK);
    char *const page = read_and_remove(path);
    assert_int_equal(occurrences(page, "class=\"trajectory\">{"), 2);
    assert_non_null(strstr(page, "<title>four &lt;b&gt; &amp; more</title>"));
    assert_null(strstr(page, "{{"));
    assert_null(strstr(page, " src=\""));
    assert_non_null(strstr(page, "default-src 'none'"));
    free(page);
    assert_int_equal(dl_player_write((const char *const *)&(char *){scene_path}, 1, path, &error),
                     DL_INPUT);
    assert_int_not_equal(access(path, F_OK), 0);
}

/* --- the command ------------------------------------------------------------------------------ */

/* Exit status of driftlab picture with these arguments; what it said in `said`. */
static int command(const char *arguments, char *said, size_t size) {
    char line[512];
    snprintf(line, sizeof line, "'%s' picture %s --out '%s' 2>&1", DL_PROGRAM, arguments, out_path);
    FILE *const pipe = popen(line, "r");
    assert_non_null(pipe);
    said[fread(said, 1, size - 1, pipe)] = '\0';
    return pclose(pipe) >> 8;
}

static void the_command_draws_what_is_asked(void **state) {
    (void)state;
    static const struct {
        const char *arguments;
        bool of_scene;
        int status;
        const char *expected; /* in the picture, or said */
    } table[] = {
        {"--step 35", false, 0, "t = 0.035 · step 35 · 4 particles · leapfrog"},
        {"--time 0.01", false, 0, "step 10"},
        {"--frame 3 --title '<title>'", false, 0, "&lt;title&gt;"},
        {"", false, 0, "step 50"},
        {"--colour state", false, 0, "states by TR299"},
        {"--window 0,2,0,4", false, 0, "outside the picture"},
        {"", true, 0, "initial state"},
        {"--step 36", false, 2, "at steps 0 to 50, every 5"},
        {"--time 0.0351", false, 2, "(step 35) and 0.04 (step 40)"},
        {"--frame 11", false, 2, "expected 0 to 10, or last"},
        {"--step 1.5", false, 2, "expected a whole number"},
        {"--step 5 --frame 1", false, 2, "expected one"},
        {"--window 2,0,0,4", false, 2, "X0 < X1"},
        {"--plane xz", false, 2, "expected xy"},
        {"--step 5", true, 2, "a scene has its initial state alone"},
        {"--colour weight", false, 2, "speed | state"},
    };
    for (size_t k = 0; k < sizeof table / sizeof *table; k++) {
        char arguments[256], said[1024];
        snprintf(arguments, sizeof arguments, "'%s' %s",
                 table[k].of_scene ? scene_path : trajectory_path, table[k].arguments);
        const int status = command(arguments, said, sizeof said);
        if (status != table[k].status)
            fail_msg("%s: exit status %d: %s", arguments, status, said);
        assert_int_equal(access(out_path, F_OK) == 0, status == 0);
        char *const svg = status ? NULL : read_and_remove(out_path);
        if (!strstr(svg ? svg : said, table[k].expected))
            fail_msg("%s: no \"%s\" in %s", arguments, table[k].expected, svg ? "it" : said);
        free(svg);
    }
}

/* A page shows every frame, in the colours that are chosen there. */
static void a_player_takes_no_options_of_a_picture(void **state) {
    (void)state;
    static const char *const options[] = {"--step 5", "--colour mass", "--velocities", "--frame 1"};
    char line[512], said[1024], page[80];
    snprintf(page, sizeof page, "%s/player.html", folder);
    for (size_t k = 0; k < sizeof options / sizeof *options; k++) {
        snprintf(line, sizeof line, "'%s' picture '%s' --out '%s' %s 2>&1", DL_PROGRAM,
                 trajectory_path, page, options[k]);
        FILE *const pipe = popen(line, "r");
        assert_non_null(pipe);
        said[fread(said, 1, sizeof said - 1, pipe)] = '\0';
        assert_int_equal(pclose(pipe) >> 8, 2);
        assert_non_null(strstr(said, "the page lets one choose"));
        assert_int_not_equal(access(page, F_OK), 0);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_circle_a_particle_sized_and_shaded_by_mass),
        cmocka_unit_test(sizes_span_little_whatever_the_masses),
        cmocka_unit_test(equal_size_is_equal),
        cmocka_unit_test(states_stand_in_hexagons_and_triangles),
        cmocka_unit_test(arrows_point_where_particles_go),
        cmocka_unit_test(colours_tell_speeds),
        cmocka_unit_test(a_window_leaves_out_and_says_so),
        cmocka_unit_test(a_window_has_a_width),
        cmocka_unit_test(the_nearer_is_drawn_last),
        cmocka_unit_test(a_system_leaves_out_what_has_escaped),
        cmocka_unit_test(periodic_directions_are_drawn_in_the_box),
        cmocka_unit_test(png_has_ink_where_the_particles_are),
        cmocka_unit_test(a_name_that_is_no_pictures_is_refused),
        cmocka_unit_test(every_frame_is_read),
        cmocka_unit_test(frames_are_found_by_step_and_time),
        cmocka_unit_test(states_follow_the_temperature),
        cmocka_unit_test(text_in_xml_is_what_xml_allows),
        cmocka_unit_test(base64_is_rfc_4648),
        cmocka_unit_test(a_player_holds_every_frame_to_its_quantum),
        cmocka_unit_test(a_player_that_would_be_too_large_is_thinned),
        cmocka_unit_test(a_page_of_players_fetches_nothing),
        cmocka_unit_test(the_command_draws_what_is_asked),
        cmocka_unit_test(a_player_takes_no_options_of_a_picture),
    };
    return cmocka_run_group_tests(tests, prepare, clean);
}
