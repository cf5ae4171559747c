//! Chromium without a window opens pages: what it says on its console, what is seen of them by day and by night, on a
//! phone and on a desk.

use std::collections::HashSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use std::{fs, thread};

use image::RgbImage;
use serde::Serialize;
use sglow_report::failure::{Context as _, Failure, Result};
use sglow_report::json::Report;
use sglow_report::page::frame::{Extras, page_with};
use sglow_report::picture::png;
use sglow_report::write;
use sglow_results::check::{Check, Relation};
use sglow_results::progress::Progress;

use crate::machine::{apt, cargo, first_line, program, target_folder};
use crate::tint::succeed;

/// The packages of Debian that bring it.
pub const PACKAGES: [&str; 1] = ["chromium"];
/// What it is called by those who package it.
const NAMES: [&str; 5] =
    ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome"];
/// Widths of a phone and of a desk, in CSS pixels.
const WIDTHS: [u32; 2] = [400, 1600];
/// The least width of a window that Chromium opens; what is narrower is a frame in it.
const LEAST_WINDOW: u32 = 500;
/// How much of a page is looked at from its top, in CSS pixels; of one that is broken on purpose a little will do.
const HEIGHTS: [u32; 2] = [9000, 900];
/// A page of text and plots has at least so many colours, for letters have soft edges; a blank one has one.
const COLOURS: usize = 32;
/// How long a page may take.
const PATIENCE: Duration = Duration::from_secs(120);
/// What the script that is put into each page begins its message with.
const PROBE: &str = "sglow-probe";

/// A browser.
pub struct Browser {
    program: PathBuf,
    version: String,
}

/// A width and a scheme of colours.
#[derive(Clone, Copy, Debug)]
struct View {
    width: u32,
    height: u32,
    dark: bool,
}

/// What was seen of a page in a view.
#[derive(Clone, Debug, Serialize)]
pub struct Seen {
    page: String,
    width: u32,
    dark: bool,
    /// What the browser said on its console.
    messages: Vec<String>,
    /// CSS pixels that the page needs beyond its window.
    too_wide: f64,
    /// Pictures that did not load.
    broken_pictures: f64,
    /// Whether the page knows the scheme, and is drawn in it.
    in_scheme: bool,
    /// Different colours on the screenshot.
    colours: usize,
}

/// What can be wrong with a page.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fault {
    /// The browser, or the script that tries the page, says something.
    Message,
    /// It has to be scrolled sideways.
    TooWide,
    /// A picture does not load.
    BrokenPicture,
    /// It does not follow the scheme of colours.
    Scheme,
    /// There is nothing to see.
    Blank,
}

impl Seen {
    fn has(&self, fault: Fault) -> bool {
        match fault {
            Fault::Message => !self.messages.is_empty(),
            Fault::TooWide => self.too_wide > 0.0,
            Fault::BrokenPicture => self.broken_pictures > 0.0,
            Fault::Scheme => !self.in_scheme,
            Fault::Blank => self.colours < COLOURS,
        }
    }
}

/// A page that is broken on purpose, and how.
struct Control {
    name: &'static str,
    text: String,
    fault: Fault,
}

impl Browser {
    /// The one that this machine has.
    ///
    /// # Errors
    ///
    /// When it has none; the help is the line to type.
    pub fn find() -> Result<Self> {
        let program = NAMES.iter().find_map(|name| program(name)).ok_or_else(|| {
            Failure::new("Chromium is not installed")
                .help(format!("type: {}", apt::line(&PACKAGES)))
        })?;
        let version = first_line(Command::new(&program).arg("--version"))
            .unwrap_or_else(|| "of unknown version".to_owned());
        Ok(Self { program, version })
    }

    /// Opens a page of made-up numbers, `pages` on disk, and pages that are broken on purpose; keeps what it saw in
    /// `pictures`.
    ///
    /// # Errors
    ///
    /// When the browser cannot be started, says nothing, or a file cannot be read or written.
    pub fn read(
        &self,
        pages: &[PathBuf],
        pictures: &Path,
        report: &mut Report,
        progress: &dyn Progress,
    ) -> Result {
        let [made_up, one] = made_up(progress)?;
        write::text(&pictures.join("made-up.html"), &made_up)?;
        let mut wanted = vec![("made-up".to_owned(), made_up)];
        for path in pages {
            let text =
                fs::read_to_string(path).context(format!("{}: cannot be read", path.display()))?;
            let folder =
                path.parent().and_then(Path::file_name).unwrap_or_default().to_string_lossy();
            let stem = path.file_stem().unwrap_or_default().to_string_lossy();
            wanted.push((format!("{folder}-{stem}"), based(&text, path)?));
        }
        let controls = controls(&one);
        let [height, short] = HEIGHTS;
        let views: Vec<View> = WIDTHS
            .iter()
            .flat_map(|&width| [false, true].map(|dark| View { width, height, dark }))
            .collect();
        progress.start("Chromium opens pages", wanted.len() * views.len() + controls.len());
        let (mut seen, mut done) = (Vec::new(), 0);
        for (name, text) in &wanted {
            for view in &views {
                seen.push(self.look(name, text, *view, Some(pictures))?);
                done += 1;
                progress.done(done);
            }
        }
        let mut refused = Vec::new();
        for control in &controls {
            let view = View { width: WIDTHS[0], height: short, dark: true };
            let looked = self.look(control.name, &control.text, view, None)?;
            refused.push((control.name, looked.has(control.fault)));
            done += 1;
            progress.done(done);
        }
        progress.end();
        record(report, &seen, &refused);
        report.versions.insert("chromium".to_owned(), self.version.clone());
        report.detail("chromium", &seen)
    }

    fn look(&self, name: &str, text: &str, view: View, pictures: Option<&Path>) -> Result<Seen> {
        let folder = tempfile::tempdir().context("no temporary folder")?;
        let place = |name: &str| folder.path().join(name);
        let keep = |name: &str, text: &str| fs::write(place(name), text).context(name);
        keep("page.html", &probed(text))?;
        keep("frame.html", &framed(view))?;
        let (said, shot) = (place("said"), place("shot.png"));
        self.open(folder.path(), view, &said, &shot)?;
        let said = fs::read(&said).context("the browser's messages cannot be read")?;
        let said = String::from_utf8_lossy(&said);
        let probe = messages(&said).into_iter().find(|message| message.starts_with(PROBE));
        let number = |key: &str| probe.as_deref().and_then(|probe| value(probe, key));
        let shot = image::open(&shot).context(format!("{name}: no picture of it"))?.to_rgb8();
        let shot = narrowed(shot, view.width);
        if let Some(pictures) = pictures {
            let scheme = if view.dark { "dark" } else { "light" };
            png::write(&pictures.join(format!("{name}-{}-{scheme}.png", view.width)), &shot)?;
        }
        let mut messages = messages(&said);
        messages.retain(|message| !message.starts_with(PROBE));
        if probe.is_none() {
            messages.push("the page did not load to its end".to_owned());
        }
        let knows = number("dark") == Some(f64::from(u8::from(view.dark)));
        Ok(Seen {
            page: name.to_owned(),
            width: view.width,
            dark: view.dark,
            messages,
            too_wide: number("needed").unwrap_or(0.0) - number("width").unwrap_or(0.0),
            broken_pictures: number("broken").unwrap_or(0.0),
            in_scheme: knows && is_dark(&shot) == view.dark,
            colours: colours(&shot),
        })
    }

    /// Opens `frame.html` of `folder`; what the browser says and a picture of what it shows lie there afterwards.
    fn open(&self, folder: &Path, view: View, said: &Path, shot: &Path) -> Result {
        let mut option = std::ffi::OsString::from("--screenshot=");
        option.push(shot);
        let mut profile = std::ffi::OsString::from("--user-data-dir=");
        profile.push(folder.join("profile"));
        let mut child = Command::new(&self.program)
            // Root has no sandbox; what is opened lies on this machine, and a report's page reaches for nothing.
            .args(["--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars"])
            .args(["--disable-background-networking", "--no-first-run", "--disable-extensions"])
            .args(["--enable-logging=stderr", "--v=0"])
            // Blink's own numbers: 0 is dark, 1 is light.
            .arg(format!("--blink-settings=preferredColorScheme={}", u8::from(!view.dark)))
            .arg(format!("--window-size={},{}", view.width.max(LEAST_WINDOW), view.height))
            .args([profile, option])
            .arg(folder.join("frame.html"))
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(fs::File::create(said).context(said.display())?)
            .spawn()
            .context(self.program.display())?;
        let begun = Instant::now();
        loop {
            if let Some(status) = child.try_wait().context(self.program.display())? {
                return if status.success() && shot.exists() {
                    Ok(())
                } else {
                    Err(failed(&self.program, &status.to_string(), said))
                };
            }
            if begun.elapsed() > PATIENCE {
                child.kill().context(self.program.display())?;
                child.wait().context(self.program.display())?;
                return Err(failed(&self.program, &format!("no end after {PATIENCE:?}"), said));
            }
            thread::sleep(Duration::from_millis(20));
        }
    }
}

fn failed(program: &Path, how: &str, said: &Path) -> Failure {
    let said = fs::read(said).unwrap_or_default();
    let said = String::from_utf8_lossy(&said);
    let lines: Vec<&str> = said.lines().collect();
    let last = &lines[lines.len().saturating_sub(6)..];
    Failure::new(format!("{} ended with {how}:\n{}", program.display(), last.join("\n")))
}

/// The page as if it lay where it does, for it is opened as a copy.
fn based(text: &str, path: &Path) -> Result<String> {
    let path = path.canonicalize().context(path.display())?;
    let folder = path.parent().unwrap_or(&path).display().to_string();
    // What has a meaning of its own in an address. [RFC 3986]
    let folder = folder.replace('%', "%25").replace('?', "%3F").replace('#', "%23");
    let base = maud::html! { base href={ "file://" (folder) "/" }; }.into_string();
    Ok(text.replacen("<head>", &format!("<head>{base}"), 1))
}

/// The page with the script that looks at it from within.
fn probed(text: &str) -> String {
    let script = format!("<script>{}</script>", include_str!("../scripts/probe.js"));
    match text.rfind("</body>") {
        Some(end) => format!("{}{script}{}", &text[..end], &text[end..]),
        None => format!("{text}{script}"),
    }
}

/// A page around the page, as narrow as it has to be; it hands on the scheme of colours.
fn framed(view: View) -> String {
    let View { width, height, .. } = view;
    format!(
        "<!doctype html><meta charset=\"utf-8\"><style>:root{{color-scheme:light dark}}body{{margin:0}}\
         iframe{{border:0;display:block;width:{width}px;height:{height}px}}</style><iframe src=\"page.html\"></iframe>"
    )
}

/// What was said on the console, message by message.
fn messages(said: &str) -> Vec<String> {
    said.lines()
        .filter_map(|line| {
            let (head, rest) = line.split_once("] \"")?;
            let text = rest.rsplit_once("\", source: ").map_or(rest, |(text, _)| text);
            head.contains(":CONSOLE").then(|| text.to_owned())
        })
        .collect()
}

/// The number after `key=`.
fn value(probe: &str, key: &str) -> Option<f64> {
    probe
        .split_whitespace()
        .find_map(|word| word.strip_prefix(key)?.strip_prefix('=')?.parse().ok())
}

/// A picture without what is right of a width.
fn narrowed(shot: RgbImage, width: u32) -> RgbImage {
    if shot.width() <= width {
        return shot;
    }
    image::imageops::crop_imm(&shot, 0, 0, width, shot.height()).to_image()
}

/// Whether the page's paper, seen at its corner, is nearer to black than to white.
fn is_dark(shot: &RgbImage) -> bool {
    let corner = shot.get_pixel_checked(1, 1).map_or([0; 3], |pixel| pixel.0);
    corner.iter().map(|&part| u32::from(part)).sum::<u32>() < 3 * 128
}

fn colours(shot: &RgbImage) -> usize {
    let mut colours = HashSet::new();
    // More than enough is not counted: a page has millions of pixels.
    shot.pixels()
        .take_while(|pixel| colours.insert(**pixel) || colours.len() < 8 * COLOURS)
        .count();
    colours.len()
}

/// The pages of made-up scenes, whole and of one scene: an example of the crate that writes pages makes them, for no
/// command has made-up numbers in it.
fn made_up(progress: &dyn Progress) -> Result<[String; 2]> {
    progress.start("making pages of made-up numbers", 0);
    let folder = tempfile::tempdir().context("no temporary folder")?;
    let build = ["build", "--quiet", "--workspace", "--example", "made_up"];
    let program = format!("debug/examples/made_up{}", std::env::consts::EXE_SUFFIX);
    let made = succeed(cargo().args(build))
        .and_then(|()| succeed(Command::new(target_folder().join(program)).arg(folder.path())));
    progress.end();
    made?;
    let read = |name: &str| fs::read_to_string(folder.path().join(name)).context(name);
    Ok([read("whole.html")?, read("one.html")?])
}

/// Pages that are broken on purpose: a browser that does not see what is wrong with one of them checks nothing.
fn controls(sound: &str) -> Vec<Control> {
    let with = |more: &str| sound.replace("</main>", &format!("{more}</main>"));
    let without = |part: &str| sound.replace(part, "");
    let blank = Extras { style: "body{display:none}", script: "" };
    let control = |name, text, fault| Control { name, text, fault };
    vec![
        control("a script that fails", with("<script>nowhere.remove();</script>"), Fault::Message),
        control("a script that cannot be read", with("<script>let = ;</script>"), Fault::Message),
        control(
            "a picture from elsewhere",
            with("<img src=\"https://sglow.invalid/picture.png\">"),
            Fault::Message,
        ),
        control(
            "a slide that moves nothing",
            without("slide.addEventListener(\"input\", move);"),
            Fault::Message,
        ),
        control(
            "a filter that hides nothing",
            without("dot.classList.toggle(\"dim\", !fit);"),
            Fault::Message,
        ),
        control(
            "a page that is too wide",
            with("<div style=\"width:2000px\">wide</div>"),
            Fault::TooWide,
        ),
        control(
            "a picture that is none",
            with("<img src=\"data:image/png;base64,AAAA\">"),
            Fault::BrokenPicture,
        ),
        control(
            "a page that is white by night",
            sound.replace("screen and (prefers-color-scheme: dark)", "print"),
            Fault::Scheme,
        ),
        control("a blank page", page_with("", &maud::html! {}, &[], blank), Fault::Blank),
    ]
}

/// Turns what was seen into checks.
fn record(report: &mut Report, seen: &[Seen], refused: &[(&str, bool)]) {
    for one in seen {
        for message in &one.messages {
            eprintln!("chromium, {} at {} pixels: {message}", one.page, one.width);
        }
    }
    let note = format!("{} views: {WIDTHS:?} pixels wide, light and dark", seen.len());
    let total = |of: &dyn Fn(&Seen) -> f64| seen.iter().map(of).sum::<f64>();
    let most = |of: &dyn Fn(&Seen) -> f64| seen.iter().map(of).fold(0.0, f64::max);
    let least = seen.iter().map(|one| one.colours).min().unwrap_or(0);
    let rows = [
        (
            "messages on the console",
            total(&|one| one.messages.len() as f64),
            "messages",
            Relation::Equal,
            0.0,
        ),
        ("wider than the window by", most(&|one| one.too_wide), "pixels", Relation::AtMost, 0.0),
        (
            "pictures that do not load",
            total(&|one| one.broken_pictures),
            "pictures",
            Relation::Equal,
            0.0,
        ),
        (
            "views in the wrong scheme",
            total(&|one| f64::from(u8::from(!one.in_scheme))),
            "views",
            Relation::Equal,
            0.0,
        ),
        (
            "colours on a screenshot, least",
            least as f64,
            "colours",
            Relation::AtLeast,
            COLOURS as f64,
        ),
    ];
    for (name, value, unit, relation, bound) in rows {
        report.check(
            Check::new(format!("chromium: {name}"), value, unit, relation, bound)
                .note(note.clone()),
        );
    }
    for (name, refused) in refused {
        let refused = f64::from(u8::from(*refused));
        report.check(
            Check::new(format!("chromium: {name} refused"), refused, "pages", Relation::Equal, 1.0)
                .note("broken on purpose"),
        );
    }
}

#[cfg(test)]
#[expect(dead_code, reason = "a part of the made-up scenes will do")]
#[path = "../../report/examples/made_up/scenes.rs"]
mod scenes;

#[cfg(test)]
mod tests {
    use super::*;

    const SAID: &str = "\
[1:1:1125/032606.394816:INFO:CONSOLE:1] \"Uncaught ReferenceError: \"x\" is not defined\", source: file:///t.html (1)
[1:1:1125/032606.4:WARNING:sandbox.cc:1] \"nothing\" of interest
[1:1:1125/032606.5:INFO:CONSOLE(12)] \"sglow-probe width=400 needed=420 dark=1 broken=0\", source: file:///t.html (12)
";

    #[test]
    fn messages_are_those_of_the_console_alone() {
        let messages = messages(SAID);
        assert_eq!(messages.len(), 2);
        assert_eq!(messages[0], "Uncaught ReferenceError: \"x\" is not defined");
        assert_eq!(value(&messages[1], "needed"), Some(420.0));
        assert_eq!(value(&messages[1], "need"), None);
    }

    #[test]
    fn the_probe_stands_within_the_page() {
        let page = probed("<body>text</body></html>");
        assert!(
            page.starts_with("<body>text<script>") && page.ends_with("</script></body></html>")
        );
        assert!(!include_str!("../scripts/probe.js").contains("</"));
    }

    #[test]
    fn a_copy_finds_what_lies_beside_the_page() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a #1.html");
        fs::write(&path, "").unwrap();
        let page = based("<html><head><title>t", &path).unwrap();
        let folder = folder.path().canonicalize().unwrap();
        assert!(
            page.starts_with(&format!("<html><head><base href=\"file://{}/\">", folder.display())),
            "{page}"
        );
        assert!(based("", &folder.join("none.html")).is_err());
    }

    #[test]
    fn every_control_differs_from_the_page_that_is_sound() {
        let sound = scenes::one();
        let controls = controls(&sound);
        assert!(controls.iter().all(|control| control.text != sound));
    }

    #[test]
    fn what_is_wrong_is_seen() {
        let sound = Seen {
            page: String::new(),
            width: 400,
            dark: false,
            messages: Vec::new(),
            too_wide: 0.0,
            broken_pictures: 0.0,
            in_scheme: true,
            colours: 500,
        };
        for (fault, wrong) in [
            (Fault::Message, Seen { messages: vec!["odd".to_owned()], ..sound.clone() }),
            (Fault::TooWide, Seen { too_wide: 1.0, ..sound.clone() }),
            (Fault::BrokenPicture, Seen { broken_pictures: 1.0, ..sound.clone() }),
            (Fault::Scheme, Seen { in_scheme: false, ..sound.clone() }),
            (Fault::Blank, Seen { colours: 1, ..sound.clone() }),
        ] {
            assert!(wrong.has(fault) && !sound.has(fault), "{fault:?}");
        }
    }
}
