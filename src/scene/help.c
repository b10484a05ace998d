#include <stdio.h>
#include <string.h>
#include "driftlab/scene.h"
#include "scene/initial.h"
#include "scene/tables.h"

enum { form_width = 26 };

static const dl_scene_section *const sections[] = {
    &dl_section_scene,    &dl_section_particle,  &dl_section_columns, &dl_section_piece,
    &dl_section_term,     &dl_section_pair,      &dl_section_walls,   &dl_section_periods,
    &dl_section_time,     &dl_section_radiation, &dl_section_lattice, &dl_section_random,
    &dl_section_exchange, &dl_section_rotation,  &dl_section_perturb, &dl_section_start,
    &dl_section_remove,
};

static const char example[] =
    "example\n"
    "    name: drop\n"
    "    source: TR323, section V, case 1\n"
    "    dimension: 2\n"
    "    particles:\n"
    "      - {file: settled.csv, mass: 1}\n"
    "      - {at: [5, 1.7], velocity: [0, 0], mass: 10}\n"
    "    pair_law:\n"
    "      - {until: 0.25, terms: [{coefficient: -25, power: 2}, {coefficient: 50, power: 4}]}\n"
    "    gravity: [0, -980]\n"
    "    walls: {x: [0, 10], y: [0, none], damping: 0.9, rule: mirror}\n"
    "    time: {step: 1.0e-4, end: 0.15}\n";

/* A form too long for its column has a line of its own. */
static void print_line(FILE *out, const char *name, const char *form, const char *doc) {
    if (strlen(form) > form_width)
        fprintf(out, "  %-14s %s\n  %-14s %-*s %s", name, form, "", form_width, "", doc);
    else
        fprintf(out, "  %-14s %-*s %s", name, form_width, form, doc);
}

static void print_row(FILE *out, const dl_parameter *row) {
    char range[128];
    dl_parameter_range(row, range, sizeof range);
    print_line(out, row->name, range, row->doc);
    if (row->unit[0])
        fprintf(out, " [%s]", row->unit);
    if (!row->fallback)
        fprintf(out, " (required)");
    else if (row->fallback[0])
        fprintf(out, " (default %s)", row->fallback);
    fputc('\n', out);
}

static void print_section(FILE *out, const dl_scene_section *section) {
    fprintf(out, "%s\n%s\n", section->title, section->doc);
    for (size_t i = 0; i < section->table.count; i++)
        print_row(out, &section->table.rows[i]);
    for (size_t i = 0; section->key[i].name; i++) {
        print_line(out, section->key[i].name, section->key[i].form, section->key[i].doc);
        fputc('\n', out);
    }
    fputc('\n', out);
}

void dl_scene_help(FILE *out) {
    fprintf(out, "A scene is a YAML file: one particle system as an initial-value problem, in\n"
                 "units of its own.\n\n");
    for (size_t i = 0; i < sizeof sections / sizeof *sections; i++)
        print_section(out, sections[i]);
    fputs(example, out);
}
