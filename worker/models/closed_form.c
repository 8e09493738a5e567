// The library's sine and cosine are written for bundles; one angle is a bundle of one.
#define LANES_PATH_PLAIN
#define LANES_VECTORS 1

#include "worker/models/closed_form.h"

#include "common/scenario/formula.h"
#include "worker/kinematics/trigonometry.h"
#include "worker/models/model.h"

#include <assert.h>
#include <glib.h>
#include <math.h>
#include <string.h>

// [rad] of a degree.
#define DEGREE 0x1.1df46a2529d39p-6

struct closed_form {
    enum scenario_model model;
    uint32_t input_count;
    uint32_t *variables; // (input_count) whose row an input is, or SCENARIO_CONSTANT
    double **held;       // (input_count) the row of an input that is the same in all designs
    double *constants;   // as in scenario.formula
    uint32_t rows;       // as in scenario.formula
    uint32_t outcome_count;
    double quadratic[3]; // of the ellipse: xx, xy, yy
};

// ---- Preparation ----

static double *held_row(double value)
{
    double *row = g_new(double, MODEL_BLOCK);
    for (uint32_t i = 0; i < MODEL_BLOCK; i++) {
        row[i] = value;
    }
    return row;
}

// A = R diag(1/a^2, 1/b^2) R^T, so that the level is d^T A d with d the distance from the centre.
static void prepare_ellipse(struct closed_form *form)
{
    const double angle = form->constants[FORMULA_ELLIPSE_ANGLE_DEG] * DEGREE;
    const double a = form->constants[FORMULA_ELLIPSE_SEMI_AXIS_1];
    const double b = form->constants[FORMULA_ELLIPSE_SEMI_AXIS_2];
    struct lanes sine, cosine;
    trigonometry_full(lanes_set(angle), &sine, &cosine);
    double s, c;
    lanes_store(&s, sine);
    lanes_store(&c, cosine);
    const double p = 1.0 / (a * a), q = 1.0 / (b * b);
    form->quadratic[0] = c * c * p + s * s * q;
    form->quadratic[1] = c * s * (p - q);
    form->quadratic[2] = s * s * p + c * c * q;
}

static uint32_t outcome_count(const struct scenario *scenario)
{
    switch (scenario->model) {
    case SCENARIO_MODEL_LINEAR:
        return scenario->formula.rows;
    case SCENARIO_MODEL_TWO_SECTION_CRASH:
    case SCENARIO_MODEL_ORDERED_CRASH:
        return 3;
    case SCENARIO_MODEL_CORRIDOR_CRASH:
        return 2;
    default:
        return 1;
    }
}

struct closed_form *closed_form_create(const struct scenario *scenario)
{
    assert(scenario->model != SCENARIO_MODEL_SMALL_OVERLAP);
    const struct scenario_formula *formula = &scenario->formula;
    struct closed_form *form = g_new0(struct closed_form, 1);
    form->model = scenario->model;
    form->input_count = formula->input_count;
    form->variables = g_new(uint32_t, formula->input_count);
    form->held = g_new0(double *, formula->input_count);
    for (uint32_t i = 0; i < formula->input_count; i++) {
        form->variables[i] = formula->inputs[i].variable;
        if (form->variables[i] == SCENARIO_CONSTANT) {
            form->held[i] = held_row(formula->inputs[i].value);
        }
    }
    form->constants = g_memdup2(formula->constants, formula->constant_count * sizeof(double));
    form->rows = formula->rows;
    form->outcome_count = outcome_count(scenario);
    if (form->model == SCENARIO_MODEL_ELLIPSE) {
        prepare_ellipse(form);
    }
    return form;
}

void closed_form_free(struct closed_form *form)
{
    if (form == NULL) {
        return;
    }
    for (uint32_t i = 0; i < form->input_count; i++) {
        g_free(form->held[i]);
    }
    g_free(form->held);
    g_free(form->variables);
    g_free(form->constants);
    g_free(form);
}

uint32_t closed_form_outcome_count(const struct closed_form *form)
{
    return form->outcome_count;
}

// ---- Evaluation ----

// The numbers of one input, a design each.
static const double *input_row(const struct closed_form *form, uint32_t input, const double *values)
{
    return form->held[input] != NULL ? form->held[input]
                                     : values + (size_t)form->variables[input] * MODEL_BLOCK;
}

static double *outcome_row(double *outcomes, uint32_t outcome)
{
    return outcomes + (size_t)outcome * MODEL_BLOCK;
}

static void set_row(double *row, uint32_t count, double value)
{
    for (uint32_t i = 0; i < count; i++) {
        row[i] = value;
    }
}

static void hypersphere(const struct closed_form *form, uint32_t count, const double *values,
                        double *restrict outcomes)
{
    const double radius = sqrt(form->input_count) / 2;
    set_row(outcomes, count, 0);
    for (uint32_t k = 0; k < form->input_count; k++) {
        const double *restrict x = input_row(form, k, values);
        for (uint32_t i = 0; i < count; i++) {
            outcomes[i] += x[i] * x[i];
        }
    }
    for (uint32_t i = 0; i < count; i++) {
        outcomes[i] = sqrt(outcomes[i]) - radius;
    }
}

static void ellipse(const struct closed_form *form, uint32_t count, const double *values,
                    double *restrict outcomes)
{
    const double *restrict x = input_row(form, FORMULA_ELLIPSE_X, values);
    const double *restrict y = input_row(form, FORMULA_ELLIPSE_Y, values);
    const double *a = form->quadratic;
    for (uint32_t i = 0; i < count; i++) {
        const double dx = x[i] - form->constants[FORMULA_ELLIPSE_CENTER_X];
        const double dy = y[i] - form->constants[FORMULA_ELLIPSE_CENTER_Y];
        outcomes[i] = a[0] * dx * dx + 2.0 * a[1] * dx * dy + a[2] * dy * dy;
    }
}

static void linear(const struct closed_form *form, uint32_t count, const double *values,
                   double *outcomes)
{
    for (uint32_t row = 0; row < form->rows; row++) {
        const double *factors = form->constants + (size_t)row * form->input_count;
        double *restrict sum = outcome_row(outcomes, row);
        set_row(sum, count, 0);
        for (uint32_t k = 0; k < form->input_count; k++) {
            const double *restrict x = input_row(form, k, values);
            for (uint32_t i = 0; i < count; i++) {
                sum[i] += factors[k] * x[i];
            }
        }
    }
}

static void rosenbrock(const struct closed_form *form, uint32_t count, const double *values,
                       double *restrict outcomes)
{
    set_row(outcomes, count, 0);
    for (uint32_t k = 0; k + 1 < form->input_count; k++) {
        const double *restrict x = input_row(form, k, values);
        const double *restrict next = input_row(form, k + 1, values);
        for (uint32_t i = 0; i < count; i++) {
            const double bend = next[i] - x[i] * x[i];
            const double rest = 1.0 - x[i];
            outcomes[i] += 100.0 * bend * bend + rest * rest;
        }
    }
}

static void two_section_crash(const struct closed_form *form, uint32_t count, const double *values,
                              double *outcomes)
{
    const double *f1 = input_row(form, FORMULA_TWO_SECTION_F1, values);
    const double *f2 = input_row(form, FORMULA_TWO_SECTION_F2, values);
    const double *mass = input_row(form, FORMULA_TWO_SECTION_MASS, values);
    const double *d1 = input_row(form, FORMULA_TWO_SECTION_D1, values);
    const double *d2 = input_row(form, FORMULA_TWO_SECTION_D2, values);
    const double *speed = input_row(form, FORMULA_TWO_SECTION_SPEED, values);
    double *energy = outcome_row(outcomes, FORMULA_TWO_SECTION_ENERGY_REMAINING);
    double *decel = outcome_row(outcomes, FORMULA_TWO_SECTION_DECEL_MAX);
    double *order = outcome_row(outcomes, FORMULA_TWO_SECTION_ORDER);
    for (uint32_t i = 0; i < count; i++) {
        energy[i] = 0.5 * mass[i] * speed[i] * speed[i] - f1[i] * d1[i] - f2[i] * d2[i];
        decel[i] = f2[i] / mass[i];
        order[i] = f1[i] - f2[i];
    }
}

static void ordered_crash(const struct closed_form *form, uint32_t count, const double *values,
                          double *outcomes)
{
    const uint32_t sections = form->input_count - FORMULA_ORDERED_FORCE;
    const double *mass = input_row(form, FORMULA_ORDERED_MASS, values);
    const double *speed = input_row(form, FORMULA_ORDERED_SPEED, values);
    double *restrict energy = outcome_row(outcomes, FORMULA_ORDERED_ENERGY_REMAINING);
    double *restrict order = outcome_row(outcomes, FORMULA_ORDERED_ORDER_MAX);
    double *restrict decel = outcome_row(outcomes, FORMULA_ORDERED_DECEL_MAX);
    for (uint32_t i = 0; i < count; i++) {
        energy[i] = 0.5 * mass[i] * speed[i] * speed[i];
        order[i] = -INFINITY;
        decel[i] = -INFINITY;
    }
    for (uint32_t k = 0; k < sections; k++) {
        const double *force = input_row(form, FORMULA_ORDERED_FORCE + k, values);
        const double *next =
            k + 1 < sections ? input_row(form, FORMULA_ORDERED_FORCE + k + 1, values) : NULL;
        for (uint32_t i = 0; i < count; i++) {
            energy[i] -= force[i] * form->constants[k];
            decel[i] = force[i] > decel[i] ? force[i] : decel[i];
        }
        for (uint32_t i = 0; next != NULL && i < count; i++) {
            const double excess = force[i] - next[i];
            order[i] = excess > order[i] ? excess : order[i];
        }
    }
    for (uint32_t i = 0; i < count; i++) {
        decel[i] /= mass[i];
    }
}

// The trapezoid rule over points that are evenly spaced: the ends count half.
static void corridor_crash(const struct closed_form *form, uint32_t count, const double *values,
                           double *outcomes)
{
    const uint32_t points = form->rows;
    const uint32_t paths = (form->input_count - FORMULA_CORRIDOR_FORCE) / points;
    const double *length = input_row(form, FORMULA_CORRIDOR_LENGTH, values);
    const double *given = input_row(form, FORMULA_CORRIDOR_ENERGY, values);
    double *restrict energy = outcome_row(outcomes, FORMULA_CORRIDOR_ENERGY_REMAINING);
    double *restrict force_max = outcome_row(outcomes, FORMULA_CORRIDOR_FORCE_MAX);
    double sum[MODEL_BLOCK]; // over the paths at one point
    set_row(energy, count, 0);
    set_row(force_max, count, -INFINITY);
    for (uint32_t k = 0; k < points; k++) {
        const double weight = k == 0 || k + 1 == points ? 0.5 : 1.0;
        set_row(sum, count, 0);
        for (uint32_t path = 0; path < paths; path++) {
            const double *force =
                input_row(form, FORMULA_CORRIDOR_FORCE + path * points + k, values);
            for (uint32_t i = 0; i < count; i++) {
                sum[i] += force[i];
            }
        }
        for (uint32_t i = 0; i < count; i++) {
            energy[i] += weight * sum[i];
            force_max[i] = sum[i] > force_max[i] ? sum[i] : force_max[i];
        }
    }
    const double intervals = points - 1;
    for (uint32_t i = 0; i < count; i++) {
        energy[i] = given[i] - energy[i] * (length[i] / intervals);
    }
}

void closed_form_evaluate(const struct closed_form *form, uint32_t count, const double *values,
                          double *outcomes)
{
    switch (form->model) {
    case SCENARIO_MODEL_HYPERSPHERE:
        hypersphere(form, count, values, outcomes);
        return;
    case SCENARIO_MODEL_ELLIPSE:
        ellipse(form, count, values, outcomes);
        return;
    case SCENARIO_MODEL_LINEAR:
        linear(form, count, values, outcomes);
        return;
    case SCENARIO_MODEL_ROSENBROCK:
        rosenbrock(form, count, values, outcomes);
        return;
    case SCENARIO_MODEL_TWO_SECTION_CRASH:
        two_section_crash(form, count, values, outcomes);
        return;
    case SCENARIO_MODEL_ORDERED_CRASH:
        ordered_crash(form, count, values, outcomes);
        return;
    case SCENARIO_MODEL_CORRIDOR_CRASH:
        corridor_crash(form, count, values, outcomes);
        return;
    case SCENARIO_MODEL_SMALL_OVERLAP:
    case SCENARIO_MODEL_COUNT:
        break;
    }
    assert(!"a model in closed form");
}
