#include "coordinator/search/cloud.h"

#include <assert.h>
#include <glib.h>
#include <string.h>

void cloud_init(struct cloud *cloud, uint32_t variables)
{
    *cloud = (struct cloud){.variables = variables};
}

void cloud_fini(struct cloud *cloud)
{
    g_free(cloud->values);
    g_free(cloud->violation);
    *cloud = (struct cloud){0};
}

void cloud_clear(struct cloud *cloud)
{
    cloud->count = 0;
}

void cloud_reserve(struct cloud *cloud, uint32_t count)
{
    assert(count <= UINT32_MAX - cloud->count);
    uint32_t needed = cloud->count + count;
    if (needed <= cloud->capacity)
        return;
    uint32_t capacity = needed > UINT32_MAX / 2 ? UINT32_MAX : needed + needed / 2 + 64;
    double *values = g_new(double, (size_t)capacity * cloud->variables);
    for (uint32_t v = 0; v < cloud->variables && cloud->count > 0; v++)
        memcpy(values + (size_t)v * capacity, cloud_column(cloud, v),
               cloud->count * sizeof *values);
    g_free(cloud->values);
    cloud->values = values;
    cloud->violation = g_renew(uint16_t, cloud->violation, capacity);
    cloud->capacity = capacity;
}

void cloud_add(struct cloud *cloud, const double *point, size_t stride, uint16_t violation)
{
    cloud_reserve(cloud, 1);
    for (uint32_t v = 0; v < cloud->variables; v++)
        cloud->values[(size_t)v * cloud->capacity + cloud->count] = point[v * stride];
    cloud->violation[cloud->count++] = violation;
}

enum { CLOUD_BLOCK = 1024 };

// Writes the indexes of those among points first .. first + count - 1 that lie in the box.
static uint32_t inside_block(const struct cloud *cloud, const struct box *box, uint32_t first,
                             uint32_t count, uint32_t index[CLOUD_BLOCK])
{
    uint8_t outside[CLOUD_BLOCK] = {0};
    for (uint32_t v = 0; v < cloud->variables; v++) {
        const double *column = cloud_column(cloud, v) + first;
        const double lower = box->lower[v];
        const double upper = box->upper[v];
        for (uint32_t i = 0; i < count; i++)
            outside[i] |= (uint8_t)((column[i] < lower) | (column[i] > upper));
    }
    uint32_t inside = 0;
    for (uint32_t i = 0; i < count; i++) {
        index[inside] = first + i;
        inside += outside[i] == 0;
    }
    return inside;
}

void cloud_add_inside(struct cloud *cloud, const struct cloud *from, const struct box *box)
{
    assert(cloud->variables == from->variables);
    cloud_reserve(cloud, from->count);
    uint32_t index[CLOUD_BLOCK + 1];
    for (uint32_t first = 0; first < from->count; first += CLOUD_BLOCK) {
        uint32_t left = from->count - first;
        uint32_t inside =
            inside_block(from, box, first, left < CLOUD_BLOCK ? left : CLOUD_BLOCK, index);
        for (uint32_t v = 0; v < cloud->variables; v++) {
            double *column = cloud->values + (size_t)v * cloud->capacity + cloud->count;
            const double *source = cloud_column(from, v);
            for (uint32_t i = 0; i < inside; i++)
                column[i] = source[index[i]];
        }
        for (uint32_t i = 0; i < inside; i++)
            cloud->violation[cloud->count + i] = from->violation[index[i]];
        cloud->count += inside;
    }
}

bool cloud_inside(const struct cloud *cloud, const struct box *box)
{
    if (cloud->count == 0)
        return true;
    for (uint32_t v = 0; v < cloud->variables; v++) {
        const double *column = cloud_column(cloud, v);
        const double lower = box->lower[v];
        const double upper = box->upper[v];
        uint32_t outside = 0;
#pragma omp simd reduction(+ : outside)
        for (uint32_t i = 0; i < cloud->count; i++)
            outside += (uint32_t)((column[i] < lower) | (column[i] > upper));
        if (outside > 0)
            return false;
    }
    return true;
}

void cloud_keep_newest(struct cloud *cloud, uint32_t count)
{
    if (cloud->count <= count)
        return;
    uint32_t drop = cloud->count - count;
    for (uint32_t v = 0; v < cloud->variables; v++) {
        double *column = cloud->values + (size_t)v * cloud->capacity;
        memmove(column, column + drop, count * sizeof *column);
    }
    memmove(cloud->violation, cloud->violation + drop, count * sizeof *cloud->violation);
    cloud->count = count;
}

struct cloud cloud_newest(const struct cloud *cloud, uint32_t count)
{
    struct cloud view = *cloud;
    if (count < cloud->count) {
        view.values += cloud->count - count;
        view.violation += cloud->count - count;
        view.count = count;
    }
    return view;
}
