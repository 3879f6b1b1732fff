/* A complete drive on a bare Cortex-M4F: set-up, check, and the interrupt of every PWM period.
 *
 * Written for the registers of an STM32F405 with phase currents on PA1 and PA2, the DC link on PA3,
 * half-bridges on TIM1, and a comparator at MOTOR_I_TRIP on PB12, active low. Your start-up file
 * has set the clock to 168 MHz, enabled the FPU, and has adc_interrupt as the ADC's vector. Compiled
 * in the tests of the exporter, not run on a board: pins and scales are yours to adapt. No library.
 * Dead time and current range are those of the motor file: the board must have the same. ADC1 reads
 * the currents one after the other, 0.7 us apart; ADC1 and ADC2 together read both at one instant.
 *
 *   make cortex_m4
 */
#include "../core/bring_up.h"
#include "../params.h"

#define REG(address) (*(volatile uint32_t *)(address))

/* ---- what belongs to the board ---- */
#define TIMER_MHZ 168u
#define AMPERES_PER_STEP (2.0f * MOTOR_ADC_RANGE / 4096.0f) /* of -range to range, 12 bits */
#define VOLTS_PER_STEP (2.0f * MOTOR_U_DC / 4096.0f)        /* of 0 to twice the rated link */
#define DEAD_TIME_STEPS ((MOTOR_DEAD_TIME_NS * TIMER_MHZ + 999u) / 1000u) /* of TIM1's clock */
#if DEAD_TIME_STEPS < 1 || DEAD_TIME_STEPS > 1008
#error "TIM1 inserts a dead time of 1 to 1008 steps: slow its clock down with CKD, or set it here"
#endif
#if MOTOR_T_S_NS / 1000u * TIMER_MHZ / 2u > 65535
#error "TIM1 counts to 65535, up and down in a period: slow its clock down with PSC, and TIMER_MHZ"
#endif
/* The same as DTG of TIM1_BDTR: in steps of 1, 2, 8 and 16, rounded up, for too short a dead time
 * shorts the DC link. */
#define DEAD_TIME_CODE(steps)                                                                      \
    ((steps) < 128u   ? (steps)                                                                    \
     : (steps) < 255u ? 0x80u + ((steps) + 1u) / 2u - 64u                                          \
     : (steps) < 505u ? 0xC0u + ((steps) + 7u) / 8u - 32u                                          \
                      : 0xE0u + ((steps) + 15u) / 16u - 32u)

#define RCC_AHB1ENR REG(0x40023830u)
#define RCC_APB2ENR REG(0x40023844u)
#define GPIOA_MODER REG(0x40020000u)
#define GPIOA_AFRH REG(0x40020024u)
#define GPIOB_MODER REG(0x40020400u)
#define GPIOB_AFRH REG(0x40020424u)
#define TIM1_CR1 REG(0x40010000u)
#define TIM1_CR2 REG(0x40010004u)
#define TIM1_SR REG(0x40010010u)
#define TIM1_EGR REG(0x40010014u)
#define TIM1_CCMR1 REG(0x40010018u)
#define TIM1_CCMR2 REG(0x4001001Cu)
#define TIM1_CCER REG(0x40010020u)
#define TIM1_ARR REG(0x4001002Cu)
#define TIM1_RCR REG(0x40010030u)
#define TIM1_CCR(phase) REG(0x40010034u + 4u * (uint32_t)(phase))
#define TIM1_BDTR REG(0x40010044u)
#define ADC1_SR REG(0x40012000u)
#define ADC1_CR1 REG(0x40012004u)
#define ADC1_CR2 REG(0x40012008u)
#define ADC1_JSQR REG(0x40012038u)
#define ADC1_JDR(rank) REG(0x4001203Cu + 4u * (uint32_t)(rank))
#define ADC_CCR REG(0x40012304u)
#define NVIC_ISER0 REG(0xE000E100u)
#define ADC_IRQ 18u

/* After a failed check the drive stays off until the next power-up: it is not built in correctly. */
enum { MODE_CHECK, MODE_RUN, MODE_TRIPPED, MODE_FAILED };
/* Faults at which the bridge opens: no voltage shorts the phases of a motor that spins. */
enum { OPEN_AT = FAULT_OVER_CURRENT | FAULT_STOPPED };

static drive_state_t drive;
#if KS_TABLE_GAINS
static gain_schedule_state_t schedule;
#define SCHEDULE_FAULT schedule.ks.fault
static drive_params_t live; /* drive_params with the gains in force */
#else
static ks_schedule_state_t schedule;
#define SCHEDULE_FAULT schedule.fault
#endif
static bring_up_state_t check;
static volatile int mode;        /* MODE_* */
static volatile float speed_rpm; /* reference, set by the application */
static volatile int reported;    /* drive.fault, for the application */
static volatile int wrong;       /* check.fault, for the application */
static volatile int scheduled;   /* fault of the schedule, for the application */
static volatile int restart;     /* set by the application after a trip, once its cause is gone */
static float offset_a, offset_b; /* of the current channels [steps] */
static int32_t offset_samples;

static void bridge_on(void) { TIM1_BDTR |= 1u << 15; } /* MOE */
static void bridge_off(void) { TIM1_BDTR &= ~(1u << 15); }

/* Duties of a stator voltage: inverse Clarke, common-mode voltage that centres the legs, one half
 * for no voltage. */
static void pwm_set_next(ab_t u, float u_dc) {
    float leg[3] = {
        u.a,
        -0.5f * u.a + HALF_SQRT3_F * u.b,
        -0.5f * u.a - HALF_SQRT3_F * u.b,
    };
    float high = max_f(leg[0], max_f(leg[1], leg[2]));
    float low = min_f(leg[0], min_f(leg[1], leg[2]));
    float scale = guard_inv_link(&drive_params.guard, u_dc);
    for (int j = 0; j < 3; j++) {
        float duty = clamp_f(0.5f + (leg[j] - 0.5f * (high + low)) * scale, 0.0f, 1.0f);
        TIM1_CCR(j) = (uint32_t)(duty * (float)TIM1_ARR + 0.5f);
    }
}

#if DRIVE_FINDS_ROTOR
#define SHAFT_ANGLE 0.0f
#elif !defined(SHAFT_ANGLE)
#error                                                                                             \
    "this machine does not show its pole: align its shaft, and define SHAFT_ANGLE [rad, electrical]"
#endif

/* Angle and pole are unknown, as at power-up and after a trip; without DRIVE_FINDS_ROTOR the shaft
 * stands at SHAFT_ANGLE, 60 degrees off at most. Not while the bridge is on: with a large table this
 * takes longer than a period. */
static void control_start(void) {
    drive_init(&drive_params, &drive, SHAFT_ANGLE, 0.0f, 1.0f);
#if DRIVE_FINDS_ROTOR
    drive_find_rotor(&drive);
#endif
#if KS_TABLE_GAINS
    gain_schedule_init(&gain_schedule_params, &schedule, &drive_params, &live);
#else
    ks_schedule_init(&schedule_params, &schedule);
#endif
}

static ab_t control(float i_a, float i_b, float u_dc) {
    float omega_ref = speed_rpm * (TWO_PI_F / 60.0f) * (float)MOTOR_POLE_PAIRS;
    drive_in_t in = {i_a, i_b, u_dc, omega_ref, 0.0f};
#if KS_TABLE_GAINS
    in.k_s_ref =
        gain_schedule_step(&gain_schedule_params, &schedule, &drive_params, &live, &drive.signal);
    return drive_step(&live, &drive, &in);
#else
    in.k_s_ref = ks_schedule_step(&schedule_params, &schedule, &drive_params.signal, &drive.signal);
    return drive_step(&drive_params, &drive, &in);
#endif
}

/* End of the injected conversions, which TIM1 triggers at the top of its count, where all low-side
 * switches are on. The duties written here are loaded at the next top: one period of delay. */
void adc_interrupt(void);
void adc_interrupt(void) {
    ADC1_SR = ~(1u << 2); /* JEOC */
    float steps_a = (float)ADC1_JDR(0);
    float steps_b = (float)ADC1_JDR(1);
    float u_dc = VOLTS_PER_STEP * (float)ADC1_JDR(2);
    if (offset_samples < 1024) { /* with the bridge open, before anything else */
        offset_a += steps_a * (1.0f / 1024.0f);
        offset_b += steps_b * (1.0f / 1024.0f);
        offset_samples++;
        if (offset_samples == 1024) {
            bridge_on();
        }
        return;
    }
    float i_a = AMPERES_PER_STEP * (steps_a - offset_a);
    float i_b = AMPERES_PER_STEP * (steps_b - offset_b);
    int broken = (TIM1_SR & 1u << 7) != 0; /* BIF: the break input has opened the bridge */
    ab_t u = {0.0f, 0.0f};
    if (mode == MODE_CHECK) {
        u = bring_up_step(&bring_up_params, &check, i_a, i_b);
        if (broken || check.phase == BRING_UP_DONE) {
            bridge_off();
            reported |= broken ? FAULT_OVER_CURRENT : 0;
            wrong = broken ? 0 : check.fault; /* on an open bridge it tells nothing */
            mode = broken || wrong != 0 ? MODE_FAILED : MODE_RUN;
            if (mode == MODE_RUN) {
                control_start();
                pwm_set_next(u, u_dc); /* no voltage */
                bridge_on();
            }
        }
    } else if (mode == MODE_TRIPPED && restart != 0) { /* with the bridge open */
        restart = 0;
        reported = 0;
        TIM1_SR = ~(1u << 7); /* BIF */
        control_start();
        pwm_set_next(u, u_dc); /* no voltage */
        bridge_on();
        mode = MODE_RUN;
    } else if (mode == MODE_RUN) {
        u = control(i_a, i_b, u_dc);
        if (broken) {
            drive_trip(&drive);
        }
        reported |= drive.fault;
        scheduled |= SCHEDULE_FAULT;
        mode = (drive.fault & OPEN_AT) != 0 ? MODE_TRIPPED : MODE_RUN;
    }
    if (mode == MODE_TRIPPED || mode == MODE_FAILED) {
        bridge_off();
        u.a = 0.0f;
        u.b = 0.0f;
    }
    pwm_set_next(u, u_dc);
}

static void pins(void) {
    RCC_AHB1ENR |= 3u;                /* ports A and B */
    RCC_APB2ENR |= 1u | 1u << 8;      /* TIM1, ADC1 */
    GPIOA_MODER |= 0x2A0000u | 0xFCu; /* PA8 to PA10 alternate, PA1 to PA3 analog */
    GPIOA_AFRH |= 0x111u;             /* TIM1_CH1 to CH3 */
    GPIOB_MODER |= 0xAA000000u;       /* PB12 to PB15 alternate */
    GPIOB_AFRH |= 0x11110000u;        /* TIM1_BKIN, CH1N to CH3N */
}

/* Centre-aligned: up and down once in a period. Preloaded duties; one update event a period (RCR =
 * 1), at the top, by starting to count down from a first update at the bottom. */
static void timer(void) {
    TIM1_CR1 = 1u << 7 | 1u << 5; /* ARPE, centre-aligned mode 1 */
    TIM1_ARR = (uint32_t)(0.5e6f * (float)TIMER_MHZ * MOTOR_T_S + 0.5f);
    TIM1_CCMR1 = 0x6868u; /* PWM 1, preload, channels 1 and 2 */
    TIM1_CCMR2 = 0x7868u; /* channel 3; channel 4 triggers */
    TIM1_CCR(3) = TIM1_ARR - 1u;
    TIM1_CR2 = 7u << 4;  /* OC4REF as trigger output */
    TIM1_CCER = 0x1555u; /* outputs and complements on */
    /* the break input opens the bridge in hardware; an open one has its gates driven low, not
     * floating (OSSI, OSSR) */
    TIM1_BDTR = 1u << 12 | 3u << 10 | DEAD_TIME_CODE(DEAD_TIME_STEPS);
    TIM1_RCR = 1u;
    TIM1_EGR = 1u;
}

static void converter(void) {
    ADC_CCR = 1u << 16;           /* 84 MHz of APB2 over 4: the converter takes at most 36 MHz */
    ADC1_CR1 = 1u << 8 | 1u << 7; /* scan, interrupt at the end */
    ADC1_JSQR = 2u << 20 | 3u << 15 | 2u << 10 | 1u << 5; /* channels 1, 2, 3 */
    ADC1_CR2 = 1u | 1u << 16 | 1u << 20;                  /* on; TIM1_TRGO, rising edge */
    NVIC_ISER0 = 1u << ADC_IRQ;
}

int main(void);
int main(void) {
    bring_up_init(&check);
    mode = MODE_CHECK;
    pins();
    timer();
    converter();
    TIM1_CR1 |= 1u;
    for (;;) { /* the application: speed_rpm and restart in, reported, wrong and drive.est out */
        speed_rpm = reported == 0 ? 150.0f : 0.0f;
    }
}
