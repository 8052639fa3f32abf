
/* ---- test vectors: cc -DHANNES_SELF_TEST FILE.c -lm, then run it -------------------------------- */

#ifdef HANNES_SELF_TEST
#include <stdio.h>
#include <stdlib.h>

/* A closure over something of a drawn place and stiffness, by plain sums and products. */
struct Drawn {
    uint32_t seed, count;
    double free, place, slope, shaft;
};

static double draw(struct Drawn *d)
{
    d->seed = d->seed * 1664525u + 1013904223u;
    return (d->seed >> 16) / 65536.0;
}

static void drawn_begin(struct Drawn *d, uint32_t seed)
{
    memset(d, 0, sizeof *d);
    d->seed = seed;
    d->free = 0.2 + 0.2 * draw(d);
    d->place = 2.0 + 6.0 * draw(d);
    d->slope = draw(d);
    d->slope = 0.05 + 2.0 * d->slope * d->slope;
}

static void drawn_sample(struct Drawn *d, double *sample)
{
    double since = d->count++ * HANNES_PERIOD, closing = 15.4 * since, opening = 25.6 * (1.022 - since);
    double asked = closing < opening ? closing : opening, squeeze;
    if (asked < 0.0) asked = 0.0;
    squeeze = d->shaft - d->place;
    if (squeeze < 0.0) squeeze = 0.0;
    d->shaft += 0.06 * (asked - d->shaft) / (1.0 + d->slope * squeeze);
    sample[0] = (asked >= d->shaft ? d->free : -0.5 * d->free) + d->slope * squeeze
        + 0.02 * (draw(d) - 0.5);
    sample[1] = d->shaft;
    sample[2] = asked;
}

static uint64_t mixed(uint64_t hash, uint64_t bits, int bytes)
{
    for (int k = 0; k < bytes; k++) hash = (hash ^ (bits >> 8 * k & 0xFFu)) * 1099511628211u;
    return hash;
}

static uint64_t mixed_row(uint64_t hash, const struct Hannes *h, double probability)
{
    uint64_t wide;
    for (int k = 0; k < HANNES_FEATURES; k++) {
        float value = h->row[k] + 0.0f; /* one zero, whatever its sign */
        uint32_t bits;
        memcpy(&bits, &value, 4);
        hash = mixed(hash, bits, 4);
    }
    memcpy(&wide, &probability, 8);
    return mixed(hash, wide, 8);
}

static bool near(const double *value, const double *wanted)
{
    for (int k = 0; k < 3; k++)
        if (fabs(value[k] - wanted[k]) > 1e-9 * fabs(wanted[k])) return false;
    return true;
}

static int vector_fails(struct Hannes *h, const struct HannesVector *v)
{
    struct HannesDecision said;
    struct Drawn d;
    uint64_t hash = 14695981039346656037u;
    uint32_t window = 0;
    double force[3] = {0}, stiffness[3] = {0};
    hannes_reset(h);
    drawn_begin(&d, v->seed);
    for (uint32_t k = 0; k < HANNES_VECTOR_SAMPLES; k++) {
        double sample[3];
        drawn_sample(&d, sample);
        if (!hannes_sample(h, sample[0], sample[1], sample[2], &said)) continue;
        hash = mixed_row(hash, h, said.window);
        if (said.word != v->words[window++] - '0') return 1;
        if (said.stiff) memcpy(stiffness, said.stiffness, sizeof stiffness);
        if (said.held) memcpy(force, said.force, sizeof force);
    }
    return hash != v->hash || !near(stiffness, v->stiffness) || !near(force, v->force);
}

/* Reads grasps instead: u32 samples, then current, position, reference of each as double; says of
 * each window word, held, stiff as u8 and window, rigid, stiffness, force as double. */
static int answer_grasps(struct Hannes *h)
{
    uint32_t samples;
    while (fread(&samples, 4, 1, stdin) == 1) {
        hannes_reset(h);
        for (uint32_t k = 0; k < samples; k++) {
            struct HannesDecision said;
            double s[3];
            if (fread(s, 8, 3, stdin) != 3) return 1;
            if (!hannes_sample(h, s[0], s[1], s[2], &said)) continue;
            fputc(said.word, stdout);
            fputc(said.held, stdout);
            fputc(said.stiff, stdout);
            fwrite(&said.window, 8, 1, stdout);
            fwrite(&said.rigid, 8, 1, stdout);
            fwrite(said.stiffness, 8, 3, stdout);
            fwrite(said.force, 8, 3, stdout);
        }
    }
    return 0;
}

int main(int count, char **words)
{
    static struct Hannes hannes;
    int failed = 0;
    if (count > 1 && !strcmp(words[1], "-")) return answer_grasps(&hannes);
    for (unsigned k = 0; k < sizeof hannes_vectors / sizeof *hannes_vectors; k++)
        failed += vector_fails(&hannes, &hannes_vectors[k]);
    printf("%d of %u test vectors failed\n", failed,
           (unsigned)(sizeof hannes_vectors / sizeof *hannes_vectors));
    return failed ? 1 : 0;
}
#endif
