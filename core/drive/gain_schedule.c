/* Decides on k_s, and in the periods after that on the gains. */
#include "gain_schedule.h"

#include "ks_lookup.h"

#define PARAMS_N (sizeof(drive_params_t) / 4U)
typedef char params_have_their_bits[PARAMS_N <= 32U * SET_N ? 1 : -1];

/* Word k of the parameters, whatever is in it. */
static uint32_t word_at(const drive_params_t *p, uint32_t k) {
    const unsigned char *b = (const unsigned char *)p + 4U * k;
    return b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

int gain_schedule_init(const gain_schedule_params_t *p, gain_schedule_state_t *x,
                       const drive_params_t *drive, drive_params_t *live) {
    int found = ks_schedule_init(&p->ks, &x->ks);
    if (found == KS_OK) {
        found = p->table != 0 && p->values != 0 ? gain_table_check(p->table, p->ks.table, p->values)
                                                : KS_BAD_MAGIC;
    }
    *live = *drive;
    x->check = found == KS_OK ? KS_GOOD : found;
    x->ks.fault |= found == KS_OK ? 0 : KS_FAULT_GAINS;
    x->next = 0;
    x->word = 0;
    for (uint32_t g = 0; found == KS_OK && g < p->table->n_gains; g++) {
        gain_apply(p->table->gain[g], 8.0f, drive, live); /* changes every word that it may */
    }
    for (uint32_t k = 0; k < PARAMS_N; k++) {
        uint32_t bit = word_at(drive, k) != word_at(live, k) ? 1U : 0U;
        x->set[k / 32U] = (k % 32U ? x->set[k / 32U] : 0U) | bit << k % 32U;
    }
    *live = *drive;
    for (int g = 0; g < GAIN_N; g++) {
        x->value[g] = 0.0f;
    }
    return found;
}

/* k_s at the present signals, whose place is kept. */
static float decide(const gain_schedule_params_t *p, gain_schedule_state_t *x,
                    const signal_params_t *signal_params, const signal_state_t *signals) {
    float y[SIGNAL_N];
    int finite = ks_read_axes(p->ks.table, signal_params, signals, y);
    x->ks.fault |= finite ? 0 : KS_FAULT_INPUT;
    x->next = finite ? 0 : p->table->n_gains;
    ks_table_place(p->ks.table, y, &x->cell);
    return ks_table_at(p->ks.table, p->ks.values, &x->cell);
}

/* The next gain; none until the next decision if the place of the last one is damaged. */
static void advance(const gain_schedule_params_t *p, gain_schedule_state_t *x,
                    const drive_params_t *drive, drive_params_t *live) {
    uint32_t g = x->next;
    if (x->cell.not_at != ~x->cell.at) {
        x->ks.fault |= KS_FAULT_INPUT;
        x->next = p->table->n_gains;
        return;
    }
    float wanted = gain_table_at(p->table, p->ks.table, p->values, &x->cell, g);
    x->value[g] =
        gain_step(&p->table->limit[g], p->table->gain[g], x->value[g], wanted, drive, live);
    x->next = g + 1;
}

/* Copies word k from the parameters. */
CORE_COLD static void restore(const drive_params_t *drive, drive_params_t *live, uint32_t k) {
    const unsigned char *from = (const unsigned char *)drive + 4U * k;
    unsigned char *to = (unsigned char *)live + 4U * k;
    for (int j = 0; j < 4; j++) {
        to[j] = from[j];
    }
}

/* Compares the next word of `live` with the parameters. A damaged bit of `set` does no harm: it
 * leaves a word as it is, or a gain static until its table comes next. */
static void compare(gain_schedule_state_t *x, const drive_params_t *drive, drive_params_t *live) {
    uint32_t k = x->word < PARAMS_N ? x->word : 0;
    if (word_at(drive, k) != word_at(live, k) && !(x->set[k / 32U] >> k % 32U & 1U)) {
        restore(drive, live, k);
        x->ks.fault |= KS_FAULT_PARAMS;
    }
    x->word = k + 1;
}

/* Takes the static gains where check is neither good nor what an init may have found. */
CORE_COLD static void give_up(gain_schedule_state_t *x, const drive_params_t *drive,
                              drive_params_t *live) {
    if (x->check < KS_BAD_MAGIC || x->check > KS_BAD_MOTOR) {
        *live = *drive;
        for (uint32_t j = 0; j < SET_N; j++) {
            x->set[j] = 0;
        }
        x->check = KS_BAD_MAGIC;
    }
    x->ks.fault |= KS_FAULT_GAINS;
}

float gain_schedule_step(const gain_schedule_params_t *p, gain_schedule_state_t *x,
                         const drive_params_t *drive, drive_params_t *live,
                         const signal_state_t *signals) {
    if (x->check != KS_GOOD) {
        give_up(x, drive, live);
        compare(x, drive, live);
        return ks_schedule_step(&p->ks, &x->ks, &drive->signal, signals);
    }
    if (x->ks.wait <= 0 || x->ks.wait > p->ks.periods) {
        x->ks.k_s_ref = decide(p, x, &drive->signal, signals);
        x->ks.wait = p->ks.periods;
        compare(x, drive, live);
    } else if (x->next < p->table->n_gains) {
        advance(p, x, drive, live);
    } else {
        compare(x, drive, live);
    }
    x->ks.wait -= 1;
    while (x->ks.wait == 0 && x->next < p->table->n_gains) {
        advance(p, x, drive, live);
    }
    return x->ks.k_s_ref;
}
