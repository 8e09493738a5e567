// Clouds and boxes from literals, for tests that are worked out by hand.
#ifndef SOBOX_TESTS_UNIT_COORDINATOR_SEARCH_CLOUD_OF_H
#define SOBOX_TESTS_UNIT_COORDINATOR_SEARCH_CLOUD_OF_H

#include "coordinator/search/cloud.h"

// A cloud of `count` points of `variables` coordinates each, point by point.
static inline struct cloud cloud_of(uint32_t variables, uint32_t count, const double *points)
{
    struct cloud cloud;
    cloud_init(&cloud, variables);
    for (uint32_t i = 0; i < count; i++)
        cloud_add(&cloud, points + (size_t)i * variables, 1, 1);
    return cloud;
}

#define CLOUD(variables, ...)                                                           \
    cloud_of(variables, sizeof((double[]){__VA_ARGS__}) / sizeof(double) / (variables), \
             (double[]){__VA_ARGS__})

// The same interval in every variable.
static inline struct box box_cube(uint32_t variables, double lower, double upper)
{
    struct box box;
    box_init(&box, variables);
    for (uint32_t v = 0; v < variables; v++) {
        box.lower[v] = lower;
        box.upper[v] = upper;
    }
    return box;
}

#endif
