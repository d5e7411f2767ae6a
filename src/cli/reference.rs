//! `gibs reference`: path-traced ground truth.
use super::CommandError;
use super::scene::SceneArgs;

/// Path-trace ground truth
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneArgs,
}

/// Runs the command.
pub fn run(args: &Args) -> Result<(), CommandError> {
    let _ = args.scene.load()?;
    Ok(())
}
