//! The command line that all examples share, and running an example as it says.
//!
//! In: [`OutputArgs`] and a function that adds the example's systems to an [`App`]. Out: a window until it is closed, or
//! one PNG. Whatever fails is one line on stderr and exit code 2, like clap's own errors.
#![allow(clippy::print_stderr, reason = "errors of the command line")]

use std::{env, ffi::OsString, panic, path::PathBuf, process::ExitCode};

use bevy::{asset::UnapprovedPathMode, prelude::*, window::WindowResolution};
use clap::{Args, Parser};

use super::{
    clock::Clock,
    gltf::gltf_plugin,
    headless::{ReadyChecks, headless_app, is_blank, picture, probe_gpu, save_png},
    patterns::patterns_rest,
    scene::StudioPlugin,
};

/// Exit code of a failure that the user can mend.
const FAILURE: u8 = 2;

/// Where an example draws to. Flatten it into the example's own arguments.
#[derive(Args, Clone, Debug)]
pub struct OutputArgs {
    /// Draw one picture into this PNG file instead of opening a window
    #[arg(long, value_name = "FILE", value_parser = parse_png)]
    pub screenshot: Option<PathBuf>,
    /// Size of the picture or window in pixels
    #[arg(long, value_name = "WxH", default_value = "800x600", value_parser = parse_size)]
    pub size: UVec2,
}

/// Refused before anything is drawn.
fn parse_png(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    let is_png = path
        .extension()
        .is_some_and(|ending| ending.eq_ignore_ascii_case("png"));
    if is_png {
        Ok(path)
    } else {
        Err("the name of a picture must end in .png".into())
    }
}

fn parse_size(text: &str) -> Result<UVec2, String> {
    const SIDES: std::ops::RangeInclusive<u32> = 16..=8192;
    let side = |text: &str| text.parse().ok().filter(|side| SIDES.contains(side));
    text.split_once(['x', 'X'])
        .and_then(|(width, height)| Some(UVec2::new(side(width)?, side(height)?)))
        .ok_or_else(|| format!("write it as 800x600, each side {} to {}", SIDES.start(), SIDES.end()))
}

/// Builds an app with Bevy's plugins, the studio and what `setup` adds, and runs it as `args` say.
///
/// `setup` may fail, for instance because a file cannot be read.
pub fn run(title: &str, args: &OutputArgs, setup: impl FnOnce(&mut App) -> Result<(), String>) -> ExitCode {
    run_on(StudioPlugin, title, args, setup)
}

/// The same with another `stage`: the plugin that brings camera and lights.
pub fn run_on(
    stage: impl Plugin,
    title: &str,
    args: &OutputArgs,
    setup: impl FnOnce(&mut App) -> Result<(), String>,
) -> ExitCode {
    let outcome = without_stack_trace(|| match &args.screenshot {
        Some(file) => {
            let mut app = headless_app(args.size)?;
            app.add_plugins(stage);
            app.world_mut().resource_mut::<ReadyChecks>().0.push(patterns_rest);
            setup(&mut app)?;
            let picture = picture(&mut app)?;
            save_png(&picture, file)?;
            if is_blank(&picture) {
                Err(format!("{}: the picture is blank", file.display()))
            } else {
                Ok(())
            }
        }
        None => {
            let mut app = window_app(title, args.size)?;
            app.add_plugins(stage);
            setup(&mut app)?;
            if app.run().is_error() {
                Err("the renderer stopped; the log above says why".into())
            } else {
                Ok(())
            }
        }
    });
    match outcome {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => refuse(&message),
    }
}

/// Says in one line what the user can mend.
pub fn refuse(message: &str) -> ExitCode {
    eprintln!("error: {message}");
    ExitCode::from(FAILURE)
}

/// [`run`] for an example without arguments of its own, whose `setup` cannot fail.
pub fn run_plain(title: &str, setup: impl FnOnce(&mut App)) -> ExitCode {
    run(title, &OutputOnly::parse().output, |app| {
        setup(app);
        Ok(())
    })
}

/// [`run_plain`] for an example that moves by itself: with a [`Clock`] that begins `lead` seconds before the `moment` of
/// the picture.
pub fn run_moving(title: &str, moment: f32, lead: f32, setup: impl FnOnce(&mut App)) -> ExitCode {
    let output = OutputOnly::parse().output;
    run(title, &output, |app| {
        Clock::start(app, &output, moment, lead);
        setup(app);
        Ok(())
    })
}

/// Draws one example of field-aligned patterns.
#[derive(Parser)]
struct OutputOnly {
    #[command(flatten)]
    output: OutputArgs,
}

fn window_app(title: &str, size: UVec2) -> Result<App, String> {
    let has = |variable: &str| env::var_os(variable).unwrap_or_default() != OsString::new();
    if cfg!(all(unix, not(target_os = "macos"))) && !has("DISPLAY") && !has("WAYLAND_DISPLAY") {
        return Err("there is no display to open a window on; draw a picture with --screenshot FILE.png".into());
    }
    probe_gpu()?;
    let window = Window {
        title: title.into(),
        resolution: WindowResolution::new(size.x, size.y),
        ..default()
    };
    let mut app = App::new();
    app.add_plugins(
        DefaultPlugins
            .set(WindowPlugin {
                primary_window: Some(window),
                ..default()
            })
            // Meshes are opened from wherever the user keeps them.
            .set(AssetPlugin {
                unapproved_path_mode: UnapprovedPathMode::Allow,
                ..default()
            })
            .set(gltf_plugin()),
    );
    Ok(app)
}

/// Turns a panic, such as the window library's when the display cannot be reached, into an error of one line.
/// With `RUST_BACKTRACE` set, panics are left as they are.
fn without_stack_trace(work: impl FnOnce() -> Result<(), String>) -> Result<(), String> {
    if env::var_os("RUST_BACKTRACE").is_some() {
        return work();
    }
    panic::set_hook(Box::new(|_| {}));
    let outcome = panic::catch_unwind(panic::AssertUnwindSafe(work));
    let _ = panic::take_hook();
    outcome.unwrap_or_else(|panic| {
        let message = match (panic.downcast_ref::<String>(), panic.downcast_ref::<&str>()) {
            (Some(message), _) => message,
            (_, Some(&message)) => message,
            _ => "unknown cause",
        };
        let line = message.lines().next().unwrap_or_default();
        Err(if line.contains("event loop") {
            format!(
                "no window can be opened; on Debian and Ubuntu install libxcursor1 libxi6 libxkbcommon-x11-0, \
                 or draw a picture with --screenshot FILE.png ({line})"
            )
        } else {
            format!("{line} (set RUST_BACKTRACE=1 to see where)")
        })
    })
}
